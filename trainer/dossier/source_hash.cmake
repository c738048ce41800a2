# cmake -DOUTPUT=file.cpp -DROOT=dir "-DFILES=path;..." -P source_hash.cmake
# Writes a C++ source with the SHA-256 of the program's own sources, as a person can compute it in the source tree:
#   find runtime codegen trainer -type f | LC_ALL=C sort | xargs sha256sum | sha256sum
set(lines "")
foreach(path IN LISTS FILES)
  file(SHA256 "${ROOT}/${path}" hash)
  string(APPEND lines "${hash}  ${path}\n")
endforeach()
string(SHA256 all "${lines}")
file(WRITE "${OUTPUT}" "// Made by trainer/dossier/source_hash.cmake.
#include \"trainer/dossier/source_hash.h\"

namespace nlo::trainer {

const char* const kSourceHash = \"${all}\";

}  // namespace nlo::trainer
")
