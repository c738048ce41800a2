# cmake -DOUTPUT=file.cpp "-DTEXTS=name=path;..." -P embed_texts.cmake
# Writes a C++ source with the texts of files, because an installed `nlo` has no source tree.
set(entries "")
foreach(text IN LISTS TEXTS)
  string(REGEX MATCH "^([^=]+)=(.*)$" matched "${text}")
  set(name "${CMAKE_MATCH_1}")
  file(READ "${CMAKE_MATCH_2}" content)
  string(APPEND entries "    {\"${name}\", R\"embedded(${content})embedded\"sv},\n")
endforeach()
file(WRITE "${OUTPUT}" "// Made by codegen/cmake/embed_texts.cmake.
#include \"codegen/base/embedded_text.h\"

namespace nlo::codegen {

std::span<const EmbeddedText> embedded_texts() {
  using namespace std::string_view_literals; // the length comes with the literal: to count it takes clang too many steps
  static constexpr EmbeddedText kTexts[] = {
${entries}  };
  return kTexts;
}

}  // namespace nlo::codegen
")
