// SPDX-License-Identifier: MIT
// Controls of symbol_audit.sh: one defect for each -DCONTROL, which the audit must find.
#include <cmath>
#include <cstdlib>

#if CONTROL == 1  // libm
extern "C" float audited_loop(float y) {
  return std::tanh(y);
}
#elif CONTROL == 2  // the heap
extern "C" float* audited_loop(int n) {
  return new float[static_cast<unsigned>(n)];
}
#elif CONTROL == 3  // a guarded static
extern "C" float expensive();
extern "C" float audited_loop() {
  static const float once = expensive();
  return once;
}
#elif CONTROL == 4  // code that runs before main
static volatile float argument = 2.0F;
float started = argument * argument;
extern "C" float audited_loop() {
  return started;
}
#elif CONTROL == 5  // double arithmetic by mistake, in a function that the compiler must call
extern "C" double audited_loop(float y) {
  return std::pow(y, 0.3);
}
#endif
