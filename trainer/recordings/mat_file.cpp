// SPDX-License-Identifier: MIT
// MAT-files by libmatio. A column is a variable, a field ("rig.angle", "out.signals(2).values"), or a column of a
// matrix ("y(2)"), counted from 1 as MATLAB does.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include "codegen/base/error.h"
#include "trainer/base/nearest_name.h"
#include "trainer/recordings/mat_name.h"
#include "trainer/recordings/recording.h"

#ifdef NLO_MATIO
#include "trainer/recordings/mat_library.h"
#endif

namespace nlo::trainer {

#ifndef NLO_MATIO
Recording read_mat_file(const std::string& path, const WantedColumns&) {
  throw codegen::Error(fmt::format(
      "{}: this nlo was built without libmatio, which reads MAT-files: install libmatio-dev and build again, or write "
      "the log as CSV: writetable(table(t, y), \"log.csv\")",
      path));
}
#else
namespace {

using codegen::Error;
using Eigen::Index;
using Eigen::VectorXd;

struct CloseMat {
  void operator()(mat_t* file) const { matio().close(file); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { matio().free(variable); }
};
using Variable = std::unique_ptr<matvar_t, FreeVariable>;

template <class T>
VectorXd numbers_of(const matvar_t& variable, std::size_t count) {
  return Eigen::Map<const Eigen::Matrix<T, Eigen::Dynamic, 1> >(static_cast<const T*>(variable.data),
                                                                static_cast<Index>(count))
      .template cast<double>();
}

bool is_numeric(const matvar_t& variable) {
  return variable.class_type >= MAT_C_DOUBLE && variable.class_type <= MAT_C_UINT64;
}

class MatFile {
 public:
  explicit MatFile(const std::string& path) : path_(path), length_(std::filesystem::file_size(path)) {
    matio(path).log_to("nlo", [](int, char*) {});  // it tells the terminal, we tell the user
    file_.reset(matio().open(path.c_str(), MAT_ACC_RDONLY));
    if (!file_)
      throw Error(fmt::format("{}: is not a MAT-file that libmatio reads: save it with save(..., \"-v7\")", path));
  }

  /// All of it as numbers, dims as it has them. Throws Error where it is none, or damaged.
  struct Matrix {
    VectorXd numbers;
    std::size_t rows = 0, columns = 0;
  };

  Matrix matrix(const matvar_t& variable, const std::string& heading) const {
    const auto refuse = [&](const char* why) {
      throw Error(fmt::format("{}: {} is {}: expected a vector of numbers", path_, heading, why));
    };
    if (variable.class_type == MAT_C_OPAQUE || variable.class_type == MAT_C_OBJECT ||
        variable.class_type == MAT_C_FUNCTION)
      refuse("an object (a timeseries or a table?): save its parts, as t = ts.Time; y = ts.Data");
    if (variable.class_type == MAT_C_CHAR) refuse("text");
    if (variable.class_type == MAT_C_CELL) refuse("a cell array");
    if (variable.class_type == MAT_C_SPARSE) refuse("sparse: save full(...) of it");
    if (!is_numeric(variable)) refuse("no number");
    if (variable.isComplex != 0) refuse("complex: save real(...) and imag(...) of it");
    if (variable.rank != 2 || variable.dims == nullptr) refuse("of more than two dimensions");
    Matrix result;
    result.rows = variable.dims[0];
    result.columns = variable.dims[1];
    // Doubles may be stored as bytes, and deflated to a thousandth: what says that it is longer is not.
    const std::size_t most = length_ * (variable.compression == MAT_COMPRESSION_NONE ? 8 : 8 * 1032);
    const std::size_t size = matio().size_of(variable.class_type), bytes = std::min(variable.nbytes, most);
    if (result.columns != 0 && result.rows > bytes / size / result.columns) damaged(heading);
    const std::size_t count = result.rows * result.columns;
    if (count > 0 && variable.data == nullptr) damaged(heading);
    switch (variable.class_type) {
      case MAT_C_DOUBLE:
        result.numbers = numbers_of<double>(variable, count);
        break;
      case MAT_C_SINGLE:
        result.numbers = numbers_of<float>(variable, count);
        break;
      case MAT_C_INT8:
        result.numbers = numbers_of<std::int8_t>(variable, count);
        break;
      case MAT_C_UINT8:
        result.numbers = numbers_of<std::uint8_t>(variable, count);
        break;
      case MAT_C_INT16:
        result.numbers = numbers_of<std::int16_t>(variable, count);
        break;
      case MAT_C_UINT16:
        result.numbers = numbers_of<std::uint16_t>(variable, count);
        break;
      case MAT_C_INT32:
        result.numbers = numbers_of<std::int32_t>(variable, count);
        break;
      case MAT_C_UINT32:
        result.numbers = numbers_of<std::uint32_t>(variable, count);
        break;
      case MAT_C_INT64:
        result.numbers = numbers_of<std::int64_t>(variable, count);
        break;
      default:
        result.numbers = numbers_of<std::uint64_t>(variable, count);
    }
    return result;
  }

  /// The vector that `heading` names; `rows`: how long it must be, 0 where that is not known yet.
  VectorXd column(const std::string& heading, Index rows) {
    std::size_t of_matrix = 0;
    const Matrix found = matrix(find(heading, of_matrix), heading);
    const std::size_t longest = std::max(found.rows, found.columns), shortest = std::min(found.rows, found.columns);
    const std::string size = fmt::format("{} x {}", found.rows, found.columns);
    if (of_matrix == 0 && shortest != 1)
      throw Error(fmt::format("{}: {} is {}: write {}(1) for its first column", path_, heading, size, heading));
    const std::size_t samples = rows > 0 ? static_cast<std::size_t>(rows) : longest;
    const bool across = found.rows != samples;  // a sample for each column of the matrix
    if ((across ? found.columns : found.rows) != samples)
      throw Error(fmt::format("{}: {} is {}, and the log has {} samples: take signals of one clock, or resample", path_,
                              heading, size, samples));
    const std::size_t at = of_matrix == 0 ? 0 : of_matrix - 1, count = across ? found.rows : found.columns;
    if (at >= count) throw Error(fmt::format("{}: {} is {}: there is no ({})", path_, heading, size, of_matrix));
    const auto stride = static_cast<Index>(across ? found.rows : 1), n = static_cast<Index>(samples);
    const Index first = static_cast<Index>(across ? at : at * found.rows);
    return found.numbers(Eigen::seqN(first, n, stride));
  }

  /// What a log may be made of: each vector of numbers, each column of a matrix of few, by its heading.
  std::vector<std::pair<std::string, Index> > vectors() {
    std::vector<std::pair<std::string, Index> > found;
    matio().rewind(file_.get());
    while (Variable variable{matio().read_next(file_.get())}) {
      if (variable->name != nullptr) collect(*variable, variable->name, found);
      if (variable->name != nullptr) variables_[variable->name] = std::move(variable);
    }
    return found;
  }

 private:
  [[noreturn]] void damaged(const std::string& heading) const {
    throw Error(fmt::format("{}: ends within {}: the file is damaged or was not copied whole", path_, heading));
  }

  const matvar_t& read(const std::string& name) {
    if (const auto known = variables_.find(name); known != variables_.end()) return *known->second;
    matio().rewind(file_.get());
    Variable variable(matio().read(file_.get(), name.c_str()));
    if (!variable) {
      std::size_t count = 0;
      char** const names = matio().directory(file_.get(), &count);
      std::vector<std::string> known;
      for (std::size_t i = 0; names != nullptr && i < count; ++i)
        if (names[i] != nullptr) known.emplace_back(names[i]);
      if (std::find(known.begin(), known.end(), name) != known.end()) damaged(name);
      fail_unknown(fmt::format("variable \"{}\"", name), name, known);
    }
    return *(variables_[name] = std::move(variable));
  }

  [[noreturn]] void fail_unknown(const std::string& what, const std::string& name,
                                 const std::vector<std::string>& known) const {
    const std::string nearest = nearest_name(name, known);
    throw Error(fmt::format("{}: no {} among {}{}", path_, what,
                            known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", ")),
                            nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest)));
  }

  const matvar_t& find(const std::string& heading, std::size_t& of_matrix) {
    const auto steps = mat_steps(heading);
    if (!steps)
      throw Error(fmt::format("{}: \"{}\" does not name a variable: write y, rig.angle, out.signals(2).values or y(1)",
                              path_, heading));
    const matvar_t* at = &read(steps->front().name);
    std::string name = steps->front().name;
    for (std::size_t i = 0; i + 1 < steps->size(); ++i) {
      const MatStep& step = (*steps)[i];
      const std::string& field = (*steps)[i + 1].name;
      if (at->class_type != MAT_C_STRUCT || at->dims == nullptr || at->data == nullptr)
        throw Error(fmt::format("{}: {} is not a struct: it has no field {}", path_, name, field));
      const std::vector<std::string> fields = fields_of(*at);
      if (std::find(fields.begin(), fields.end(), field) == fields.end())
        fail_unknown(fmt::format("field \"{}\" of {}", field, name), field, fields);
      std::size_t elements = 1;
      for (int d = 0; d < at->rank; ++d) elements *= at->dims[d];
      if (std::max<std::size_t>(step.index, 1) > elements || (step.index == 0 && elements > 1))
        throw Error(fmt::format("{}: {} is {} structs: write {}(1).{} to {}({}).{}", path_, step.name, elements,
                                step.name, field, step.name, elements, field));
      at = matio().field(const_cast<matvar_t*>(at), field.c_str(), step.index == 0 ? 0 : step.index - 1);
      name += "." + field;
      if (at == nullptr) damaged(name);
    }
    of_matrix = steps->back().index;
    return *at;
  }

  static std::vector<std::string> fields_of(const matvar_t& variable) {
    std::vector<std::string> fields;
    char* const* names = matio().field_names(&variable);
    for (unsigned i = 0; names != nullptr && i < matio().fields(const_cast<matvar_t*>(&variable)); ++i)
      if (names[i] != nullptr) fields.emplace_back(names[i]);
    return fields;
  }

  static void collect(const matvar_t& variable, const std::string& name,
                      std::vector<std::pair<std::string, Index> >& into) {
    constexpr std::size_t kMostColumns = 32;
    if (variable.class_type == MAT_C_STRUCT && variable.dims != nullptr && variable.data != nullptr) {
      std::size_t elements = 1;
      for (int d = 0; d < variable.rank; ++d) elements *= variable.dims[d];
      for (std::size_t i = 0; i < std::min(elements, kMostColumns); ++i)
        for (const std::string& field : fields_of(variable))
          if (const matvar_t* part = matio().field(const_cast<matvar_t*>(&variable), field.c_str(), i))
            collect(*part, fmt::format("{}{}.{}", name, elements == 1 ? "" : fmt::format("({})", i + 1), field), into);
      return;
    }
    if (!is_numeric(variable) || variable.isComplex != 0 || variable.rank != 2 || variable.dims == nullptr) return;
    const std::size_t longest = std::max(variable.dims[0], variable.dims[1]),
                      shortest = std::min(variable.dims[0], variable.dims[1]);
    if (longest < 2 || shortest == 0 || shortest > kMostColumns) return;
    for (std::size_t j = 0; j < shortest; ++j)
      into.emplace_back(shortest == 1 ? name : fmt::format("{}({})", name, j + 1), static_cast<Index>(longest));
  }

  std::string path_;
  std::size_t length_;
  std::unique_ptr<mat_t, CloseMat> file_;
  std::map<std::string, Variable> variables_;
};

}  // namespace

Recording read_mat_file(const std::string& path, const WantedColumns& wanted) {
  MatFile file(path);
  Recording recording;
  if (!wanted.time.empty()) recording.headings.push_back(wanted.time);
  for (const WantedColumn& column : wanted.columns) recording.headings.push_back(column.heading);
  if (wanted.columns.empty()) {  // the length that most vectors have
    const auto vectors = file.vectors();
    std::map<Index, int> count;
    for (const auto& [heading, length] : vectors) ++count[length];
    const auto most =
        std::max_element(count.begin(), count.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    if (most == count.end())
      throw Error(fmt::format("{}: has no vector of numbers, also not in its structs: expected a log", path));
    for (const auto& [heading, length] : vectors)
      if (length == most->first) recording.headings.push_back(heading);
  }
  for (std::size_t j = 0; j < recording.headings.size(); ++j) {
    const VectorXd column = file.column(recording.headings[j], recording.numbers.rows());
    if (j == 0) recording.numbers.resize(column.size(), static_cast<Index>(recording.headings.size()));
    recording.numbers.col(static_cast<Index>(j)) = column;
  }
  return recording;
}
#endif

}  // namespace nlo::trainer
