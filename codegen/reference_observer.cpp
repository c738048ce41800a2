// SPDX-License-Identifier: MIT
#include "codegen/reference_observer.h"

namespace nlo::codegen {

template class ReferenceObserver<float>;
template class ReferenceObserver<double>;

}  // namespace nlo::codegen
