// SPDX-License-Identifier: MIT
// What an export must say, by the names that its text gives: codegen/readback compares it with what the text says. A
// structure lists its own beside the code that prints them; each printed constant has one row.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/text/cpp_structure.h"

namespace nlo::codegen {

struct Quantity {
  enum class Kind : std::uint8_t {
    kScalar,   ///< rounded once to the export's scalar
    kInteger,  ///< whole numbers, true and false
    kWords,
    kCode,     ///< the function has the words, without spaces between, or where values are {0} has not
    kFormula,  ///< the function computes what `formula` does
  };
  using Arrays = std::map<std::string, std::vector<double>>;

  std::string field;  ///< where the model has it: "inverse_map.layers[0].weights"
  std::string cpp;    ///< its path in the C++ header (codegen/readback/read_text.h); empty: it is not there
  std::string c99;    ///< in C99, and in the single header
  Kind kind = Kind::kScalar;
  std::vector<Eigen::Index> shape = {};  ///< empty: one value
  std::vector<double> values = {};       ///< row by row
  std::vector<std::string> words = {};
  Arrays arrays = {};  ///< what the function reads and writes, by its names there
  std::function<void(Arrays&)> formula = {};
};

class Quantities {
 public:
  explicit Quantities(const ExportSource& source) : source_(source) {}

  const ExportSource& source() const { return source_; }
  const std::vector<Quantity>& all() const { return all_; }

  void scalar(std::string field, std::string cpp, std::string c99, double value);
  void vector(std::string field, std::string cpp, std::string c99, const Eigen::VectorXd& values);
  void matrix(std::string field, std::string cpp, std::string c99, const Eigen::MatrixXd& values);
  void integer(std::string field, std::string cpp, std::string c99, double value);
  void integers(std::string field, std::string cpp, std::string c99, const Eigen::MatrixXd& values);
  void words(std::string field, std::string cpp, std::string c99, std::vector<std::string> words);
  /// Matrices of one shape, one behind the other.
  void stack(std::string field, std::string cpp, std::string c99, const std::vector<Eigen::MatrixXd>& values);

  /// What the model decides of the code: `function` of C99 says `words` if `so`, and else nowhere.
  void code(std::string field, std::string function, std::string words, bool so);
  /// A function of either text that computes of `arrays` what `formula` does.
  void formula(std::string field, std::string cpp, std::string c99, Quantity::Arrays arrays,
               std::function<void(Quantity::Arrays&)> formula);

  /// How C99 calls the tables of a network, and who evaluates it.
  enum class Tables : std::uint8_t {
    kMap,       ///< kWeights1, kBias1, ..., called by `estimate`
    kFunction,  ///< kDynamicsWeights1, ..., called by `dynamics`
    kTangent,   ///< the same with derivatives, by `dynamics_tangent`
    kOneLayer,  ///< kGates, kGatesBias; who calls it lists that
  };
  /// A network of the model: its layers in C++, called kLAYER1 and so on, and `member` of kModel; its tables in C99.
  void network(std::string_view field, const std::string& layer, Tables tables);

  /// A network that an alias in C++ has as a template's argument.
  struct Map {
    std::string field, layer;
  };
  /// `using Model = KklModel<...>` and `using Observer = KklObserver<Model>` for `name` "Kkl": what the type is made
  /// of, and behind the maps what is there of inputs, sensors that may fail, saturation and computed outputs.
  void types(const std::string& name, const std::vector<Eigen::Index>& sizes, const std::vector<Map>& maps,
             bool may_saturate = false, const std::string& between = "");

 private:
  void add(Quantity quantity);
  void layer_type(const FoldedNetwork& network, const std::string& layer, std::size_t index);
  void integer_map(const FoldedNetwork& network);
  const QuantisedNetwork* quantised_of(const FoldedNetwork& network) const;  ///< null: in the scalar
  void calls(const FoldedNetwork& network, const std::string& prefix, Tables tables);
  void error_head();
  void map_code(const FoldedNetwork& network);
  void activation_code(const FoldedNetwork& network, bool tangent);
  std::string map_type(const Map& map) const;

  const ExportSource& source_;
  std::vector<Quantity> all_;
};

}  // namespace nlo::codegen
