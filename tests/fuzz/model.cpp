// SPDX-License-Identifier: MIT
// A model file, from its JSON to its exports in C++ and C99.
#include "codegen/base/error.h"
#include "codegen/model_file/model_file.h"
#include "codegen/targets/prepared_export.h"
#include "codegen/targets/target_registry.h"
#include "tests/fuzz/fuzz.h"

using namespace nlo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  codegen::Model model;
  if (!fuzzing::accepts([&] { model = codegen::parse_model(fuzzing::text_of(bytes, size), "m.json"); })) return 0;
  const std::string json = codegen::to_json(model);
  fuzzing::require(codegen::to_json(codegen::parse_model(json, "again.json")) == json, "a model comes back as written");
  codegen::ExportOptions options;
  // int16 searches its scales in a thousand flights, so only one input in 64 uses it.
  options.scalar = size % 64 == 0 ? codegen::ScalarType::kInt16 : static_cast<codegen::ScalarType>(size % 2);
  fuzzing::accepts([&] {
    const codegen::PreparedExport prepared(model, options);
    for (const char* target : {"cpp", "c99"})
      fuzzing::accepts([&] { (void)codegen::export_target(target).generate(prepared); });
  });
  return 0;
}
