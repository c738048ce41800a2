// SPDX-License-Identifier: MIT
// Exports whose text is right, for tests that break it.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "codegen/readback/read_back.h"
#include "codegen/readback/read_text.h"
#include "codegen/targets/registry.h"
#include "tests/codegen/example_models.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {

struct Form {
  const char* target;
  TextForm form;
};
inline constexpr Form kForms[] = {{"cpp", TextForm::kCpp}, {"c99", TextForm::kC99}, {"single", TextForm::kSingle}};

/// An export whose text is right, and what stands in it.
struct Text {
  PreparedExport prepared;
  TextForm form;
  std::string text, what;
  std::vector<ReadConstant> constants;

  Text(const Model& model, const ExportOptions& options, const Form& f)
      : prepared(model, options),
        form(f.form),
        what(model.name + " as " + f.target + " in " + scalar_name(options.scalar)) {
    for (const NamedText& file : export_target(f.target).generate(prepared)) text += file.text + "\n";
    constants = read_text(text, prepared.name()).constants;
  }

  std::string refusal(const std::string& changed) const {
    return thrown_message([&] {
      check_text(prepared, form, {{"FILE", changed}});
      return 0;
    });
  }

  const ReadConstant& constant(const std::string& path) const {
    return *std::find_if(constants.begin(), constants.end(), [&](const ReadConstant& c) { return c.path == path; });
  }

  std::string with_values(const ReadConstant& c, const std::vector<std::string>& values) const {
    std::string changed = text;
    for (std::size_t i = values.size(); i-- > 0;) changed.replace(c.values[i].at, c.values[i].text.size(), values[i]);
    return changed;
  }
};

/// One model of each structure, with what it can have.
inline std::vector<Model> models_of_structures() {
  return {rig_model(),           failing_model(), driven_model(),  luenberger_model(), general_model(),
          failing_gated_model(), window_model(),  carried_model(), prior_model(),      watched_rig_model()};
}

}  // namespace nlo::codegen
