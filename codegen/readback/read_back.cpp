// SPDX-License-Identifier: MIT
#include "codegen/readback/read_back.h"

#include <nlo/kernels/panels.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "codegen/base/fail.h"
#include "codegen/base/number.h"
#include "codegen/base/splitmix.h"
#include "codegen/readback/formula_text.h"
#include "codegen/readback/read_number.h"
#include "codegen/readback/read_text.h"
#include "codegen/readback/token_stream.h"
#include "codegen/structures/module.h"

namespace nlo::codegen {
namespace {

constexpr const char* kNothingWritten = "nothing is written: this is a fault of nlo, please report it with the model";

/// To the bit: -0 is not 0.
template <class Scalar>
bool says(std::string_view text, double value) {
  using Bits = std::conditional_t<sizeof(Scalar) == 4, std::uint32_t, std::uint64_t>;
  const std::optional<Scalar> read = read_number<Scalar>(text);
  return read && std::bit_cast<Bits>(*read) == std::bit_cast<Bits>(static_cast<Scalar>(value));
}

bool says_integer(std::string_view text, double value) {
  if (text == "true" || text == "false") return value == (text == "true" ? 1.0 : 0.0);
  const std::optional<double> read = read_number<double>(text);
  return read && *read == value && text.find_first_of(".ef") == std::string_view::npos;
}

class Comparison {
 public:
  Comparison(const PreparedExport& prepared, TextForm form, const std::vector<NamedText>& files)
      : prepared_(prepared), form_(form) {
    for (const NamedText& file : files) {
      files_ += (files_.empty() ? "" : " and ") + file.path;
      ReadText text = read(file);
      for (ReadConstant& constant : text.constants) {
        const std::string path = constant.path;
        const int line = constant.line;
        if (!read_.try_emplace(path, Found<ReadConstant>{std::move(constant), file.path}).second)
          fail("{}:{}: {} is there twice; {}", file.path, line, path, kNothingWritten);
      }
      for (ReadFunction& function : text.functions) {
        const std::string path = function.path;
        functions_.try_emplace(path, Found<ReadFunction>{std::move(function), file.path});
      }
    }
  }

  void run() {
    const ExportSource source = prepared_.source();
    Quantities quantities(source);
    add_common_quantities(quantities, prepared_, form_);
    module_of(prepared_.model()).quantities(quantities);
    for (const Quantity& quantity : quantities.all()) {
      const std::string& path = form_ == TextForm::kCpp ? quantity.cpp : quantity.c99;
      if (!path.empty()) compare(own(path), quantity);
    }
    for (const auto& [path, found] : read_)
      if (const auto& [constant, file] = found; !explained_.contains(path))
        fail("{}:{}: {} is {}, and nothing of the model explains it; {}", file, constant.line, path,
             constant.values.empty() ? "{}" : constant.values.front().text, kNothingWritten);
  }

 private:
  template <class Read>
  struct Found {
    Read read;
    std::string file;
  };

  ReadText read(const NamedText& file) const {
    try {
      return read_text(file.text, prepared_.name());
    } catch (const Error& error) {
      fail("{}: {}; {}", file.path, error.what(), kNothingWritten);
    }
  }

  /// As the reader has it: C99 has the export's name before some words.
  std::string own(const std::string& word) const {
    const std::string prefix = prepared_.name() + "_";
    return word.starts_with(prefix) ? word.substr(prefix.size()) : word;
  }

  void compare(const std::string& path, const Quantity& q) {
    if (q.kind == Quantity::Kind::kCode) return compare_code(path, q);
    if (q.kind == Quantity::Kind::kFormula) return compare_formula(path, q);
    const auto found = read_.find(path);
    if (found == read_.end()) fail("{}: {} is not there, which says {}; {}", files_, path, q.field, kNothingWritten);
    const auto& [constant, file] = found->second;
    explained_.insert(path);
    if (q.kind == Quantity::Kind::kWords) return compare_words(constant, file, q);
    const std::vector<double> values = as_laid_out(path, q);
    if (constant.values.size() != values.size() || !has_shape(constant, q, values.size()))
      fail("{}:{}: {} has {} values, and by {} it must have {}; {}", file, constant.line, path, extents(constant.shape),
           q.field, extents(q.shape), kNothingWritten);
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!is(q.kind, constant.values[i].text, values[i]))
        fail("{}:{}: {}{} is {}, and by {} it must be {}; {}", file, constant.values[i].line, path,
             position(constant.shape, i), constant.values[i].text, q.field, printed(q.kind, values[i]),
             kNothingWritten);
  }

  void compare_words(const ReadConstant& constant, const std::string& file, const Quantity& q) const {
    std::string is, should;
    for (const ReadValue& value : constant.values) is += (is.empty() ? "" : " ") + value.text;
    for (const std::string& word : q.words) should += (should.empty() ? "" : " ") + word;
    // A large layer lies in memory as it does in the panels: its weights are compared so.
    if (is.starts_with("Panel")) is.erase(0, 5);
    if (is.starts_with(prepared_.name() + "_")) is = own(is);
    if (is != should)
      fail("{}:{}: {} is {}, and by {} it must be {}; {}", file, constant.line, constant.path, is, q.field, should,
           kNothingWritten);
  }

  const Found<ReadFunction>& function(const std::string& path, const Quantity& q) const {
    const auto found = functions_.find(path);
    if (found == functions_.end())
      fail("{}: the function {} is not there, which says {}; {}", files_, path, q.field, kNothingWritten);
    return found->second;
  }

  void compare_code(const std::string& path, const Quantity& q) const {
    const auto& [read, file] = function(path, q);
    const bool should = q.values.front() != 0.0;
    if ((text_of(read.body).find(q.words.front()) != std::string::npos) != should)
      fail("{}:{}: {} has {}\"{}\", and by {} it must have {}; {}", file, read.line, path, should ? "no " : "",
           q.words.front(), q.field, should ? "one" : "none", kNothingWritten);
  }

  /// At points where no formula is likely to be equal to another.
  void compare_formula(const std::string& path, const Quantity& q) const {
    const auto& [read, file] = function(path, q);
    constexpr int kPoints = 8;
    constexpr double kRounding = 1e-12;
    std::uint64_t state = 1;
    for (int point = 0; point < kPoints; ++point) {
      Quantity::Arrays got = q.arrays;
      for (auto& [name, values] : got)
        for (double& value : values) value = 0.3 + static_cast<double>(splitmix64(state) >> 11) * 0x1p-53;
      Quantity::Arrays want = got;
      q.formula(want);
      try {
        run_formula(read, is_single(), got);
      } catch (const Error& error) {
        fail("{}: {}: {}; {}", file, path, error.what(), kNothingWritten);
      }
      for (const auto& [name, values] : want)
        for (std::size_t i = 0; i < values.size(); ++i) {
          const double is = got.at(name)[i], should = values[i];
          if (std::isnan(is) ? std::isnan(should) : std::abs(is - should) <= kRounding * (1.0 + std::abs(should)))
            continue;
          fail("{}:{}: {} computes {}[{}] as {}, and by {} it must be {}; {}", file, read.line, path, name, i, is,
               q.field, should, kNothingWritten);
        }
    }
  }

  /// Row by row, or as PanelDense has it.
  std::vector<double> as_laid_out(const std::string& path, const Quantity& q) const {
    const std::string_view weights = ".weights";
    if (!path.ends_with(weights)) return q.values;
    const auto type = read_.find(path.substr(0, path.size() - weights.size()) + ".type");
    if (type == read_.end() || type->second.read.values.front().text != "PanelDense") return q.values;
    const auto out = static_cast<int>(q.shape[0]), in = static_cast<int>(q.shape[1]);
    const kernels::PanelLayout layout{in, out};
    std::vector<double> packed(static_cast<std::size_t>(layout.weights()), 0.0);
    for (int o = 0; o < out; ++o)
      for (int i = 0; i < in; ++i)
        packed[static_cast<std::size_t>(layout.weight_position(o, i))] = q.values[static_cast<std::size_t>(o * in + i)];
    return packed;
  }

  /// Flat, or with the model's rows; rows of one number each, and outer braces, count for nothing.
  bool has_shape(const ReadConstant& constant, const Quantity& q, std::size_t values) const {
    if (constant.shape.size() <= 1) return true;
    if (values != q.values.size() || constant.values.size() != values) return false;
    const auto without_ones = [](const auto& shape) {
      std::vector<std::size_t> rest;
      for (const auto extent : shape)
        if (extent != 1) rest.push_back(static_cast<std::size_t>(extent));
      return rest;
    };
    return without_ones(constant.shape) == without_ones(q.shape);
  }

  template <class Extent>
  static std::string extents(const std::vector<Extent>& shape) {
    return shape.empty() ? "1" : fmt::format("{}", fmt::join(shape, " x "));
  }

  static std::string position(const std::vector<std::size_t>& shape, std::size_t index) {
    std::string text;
    for (auto extent = shape.rbegin(); extent != shape.rend(); ++extent) {
      text.insert(0, fmt::format("[{}]", index % *extent));
      index /= *extent;
    }
    return text;
  }

  bool is_single() const { return prepared_.initialiser().scalar_bytes() == 4; }

  bool is(Quantity::Kind kind, const std::string& text, double value) const {
    if (kind == Quantity::Kind::kInteger) return says_integer(text, value);
    return is_single() ? says<float>(text, value) : says<double>(text, value);
  }
  std::string printed(Quantity::Kind kind, double value) const {
    if (kind == Quantity::Kind::kInteger) return fmt::format("{:.0f}", value);
    return is_single() ? literal(static_cast<float>(value)) : literal(value);
  }

  const PreparedExport& prepared_;
  TextForm form_;
  std::string files_;
  std::map<std::string, Found<ReadConstant>> read_;
  std::map<std::string, Found<ReadFunction>> functions_;
  std::set<std::string> explained_;
};

}  // namespace

void check_text(const PreparedExport& prepared, TextForm form, const std::vector<NamedText>& files) {
  if (form == TextForm::kCpp || prepared.options().tanh == Activation::kTanh)
    return Comparison(prepared, form, files).run();
  const PreparedExport with_tanh = prepared.with(best_tanh(prepared.options()));  // C99 has no other
  Comparison(with_tanh, form, files).run();
}

}  // namespace nlo::codegen
