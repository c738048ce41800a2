// SPDX-License-Identifier: MIT
#include "codegen/readback/read_text.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "codegen/base/fail.h"
#include "codegen/readback/initialiser_tree.h"
#include "codegen/readback/token_stream.h"

namespace nlo::codegen {
namespace {

/// A member of a structure that the text declares.
struct ReadField {
  std::string type, name;
  bool is_array;
};

class Reader {
 public:
  Reader(std::string_view text, const std::string& name) : in_(tokens_of(text)), prefix_(name + "_") {}

  ReadText all() {
    declarations("", nullptr);
    if (!in_.at_end()) fail("line {}: a closing brace too many", in_.line());
    return std::move(text_);
  }

 private:
  using Fields = std::vector<ReadField>;

  /// C99 has the export's name before what others see.
  std::string own(const std::string& word) const {
    return word.starts_with(prefix_) ? word.substr(prefix_.size()) : word;
  }

  /// Up to a closing brace, or the end. `fields`: those of the structure that is being declared.
  void declarations(const std::string& scope, Fields* fields) {
    while (!in_.at_end() && !in_.at("}")) declaration(scope, fields);
  }

  void braced(const std::string& scope, Fields* fields) {
    in_.expect("{");
    declarations(scope, fields);
    in_.expect("}");
  }

  void declaration(const std::string& scope, Fields* fields) {
    if (in_.accept(";")) return;
    if (in_.at("[")) return in_.skip_balanced();  // an attribute
    if (in_.accept("namespace")) {
      const Token inner = in_.take();
      if (!in_namespace_)
        text_.constants.push_back({"namespace", {1}, {{inner.text, inner.line, inner.at}}, inner.line});
      in_namespace_ = true;
      return braced(scope + (inner.is("weights") ? "weights::" : ""), nullptr);
    }
    if (in_.accept("extern")) {
      (void)in_.take();  // "C"
      return braced(scope, nullptr);
    }
    if (in_.accept("public") || in_.accept("private")) return in_.expect(":");
    if (in_.accept("using")) return alias(scope, fields != nullptr);
    if (in_.accept("typedef")) return type_definition(scope);
    if (in_.accept("enum")) return enumeration(scope);
    if ((in_.at("struct") || in_.at("class")) && in_.at("{", 2)) {
      (void)in_.take();
      const std::string name = in_.take().text;
      braced(scope + name + "::", &structures_[name]);
      return in_.expect(";");
    }
    variables_or_function(scope, fields);
  }

  void alias(const std::string& scope, bool of_class) {
    const Token name = in_.take();
    if (!in_.accept("=")) return in_.skip_past(";");
    const std::vector<Token> type = in_.take_until({";"});
    in_.expect(";");
    if (!of_class) add_type(scope + name.text, type, name.line);
  }

  void type_definition(const std::string& scope) {
    if (in_.accept("enum")) return enumeration(scope);
    if (in_.accept("struct") || in_.accept("union")) {
      Fields fields;
      braced(scope, &fields);
      structures_[own(in_.take().text)] = fields;
      return in_.expect(";");
    }
    std::vector<Token> type = in_.take_until({";"});
    in_.expect(";");
    const Token name = type.back();
    type.pop_back();
    add_type(scope + own(name.text), type, name.line);
  }

  /// Behind `enum`.
  void enumeration(const std::string& scope) {
    std::string inner = scope;
    if (in_.accept("class")) inner += in_.take().text + "::";
    if (in_.accept(":")) (void)in_.take();
    in_.expect("{");
    for (long value = 0; !in_.accept("}"); ++value) {
      const Token name = in_.take();
      if (in_.accept("=")) value = needed(in_.take_until({",", "}"}), name);
      (void)in_.accept(",");
      note_integer(inner + own(name.text), value, name);
    }
    if (!in_.at(";")) (void)in_.take();  // the name of a typedef
    in_.expect(";");
  }

  void note_integer(const std::string& path, long value, const Token& at) {
    integers_[path] = value;
    text_.constants.push_back({path, {}, {{std::to_string(value), at.line, at.at}}, at.line});
  }

  void variables_or_function(const std::string& scope, Fields* fields) {
    std::vector<Token> head = in_.take_head();
    if (in_.at("(")) return function(scope, head);
    const bool constant = has(head, "constexpr") || (has(head, "static") && has(head, "const"));
    for (bool first = true;; first = false) {
      if (!first) head = joined(head, in_.take_head());
      if (head.empty() || head.back().kind != Token::Kind::kWord) fail("line {}: no name is declared", in_.line());
      const Token name = head.back();
      head.pop_back();
      bool is_array = false;
      while (in_.accept("[")) {
        is_array = true;
        (void)in_.take_until({"]"});
        in_.expect("]");
      }
      if (fields != nullptr && !constant) fields->push_back({type_of(head), name.text, is_array});
      if (in_.accept("=") || in_.at("{")) {
        const InitialiserTree tree = initialiser(in_);
        if (constant) add_constant(scope + name.text, type_of(head), is_array, tree, head);
      }
      if (!in_.accept(",")) break;
    }
    in_.expect(";");
  }

  /// At the parenthesis of its parameters.
  void function(const std::string& scope, const std::vector<Token>& head) {
    const std::string name = head.empty() ? "" : own(head.back().text);
    in_.skip_balanced();
    (void)in_.take_until({";", "{"});
    if (in_.accept(";")) return;
    const std::string inside = scope + name;
    ReadFunction read{inside, {}, in_.line()};
    int calls = 0, depth = 0;
    do {
      if (in_.at("static") || in_.at("constexpr")) {
        variables_or_function(inside + ".", nullptr);
        continue;
      }
      if (in_.is_word() && in_.at("(", 1)) note_call(inside, calls);
      depth += in_.at("{") ? 1 : in_.at("}") ? -1 : 0;
      read.body.push_back(in_.take());
    } while (depth > 0);
    text_.functions.push_back(std::move(read));
  }

  /// At a function's name. A call that passes two constants evaluates a layer of a network.
  void note_call(const std::string& inside, int& calls) {
    const std::vector<std::vector<Token>> arguments = in_.arguments_ahead();
    const auto is_table = [&](const std::vector<Token>& a) { return a.size() == 1 && tables_.contains(a[0].text); };
    if (std::count_if(arguments.begin(), arguments.end(), is_table) < 2) return;
    ReadConstant call{inside + "#" + std::to_string(++calls), {arguments.size() + 1}, {}, in_.line()};
    call.values.push_back({own(in_.word()), in_.line(), in_.place()});
    for (const std::vector<Token>& a : arguments) {
      const std::optional<long> value = integer(a);
      call.values.push_back({value ? std::to_string(*value) : text_of(a), in_.line(), a.empty() ? 0 : a.front().at});
    }
    text_.constants.push_back(std::move(call));
  }

  void add_constant(const std::string& path, const std::string& type, bool is_array, const InitialiserTree& tree,
                    const std::vector<Token>& head) {
    if (has(head, "<")) add_type(path + ".type", head, tree.line);
    if (tree.is_leaf() && type == "int")
      return note_integer(path, needed(tree.leaf, tree.leaf.front()), tree.leaf.front());
    if (!tree.is_leaf()) tables_.insert(path);
    flatten(path, type, is_array, tree);
  }

  void flatten(const std::string& path, const std::string& type, bool is_array, const InitialiserTree& tree) {
    if (tree.is_leaf()) {
      text_.constants.push_back({path, {}, {{text_of(tree.leaf), tree.line, tree.leaf.front().at}}, tree.line});
      return;
    }
    if (!tree.names.empty()) {
      for (std::size_t i = 0; i < tree.children.size(); ++i)
        flatten(path + "." + tree.names[i], "", true, tree.children[i]);
      return;
    }
    if (const auto found = structures_.find(type); found != structures_.end() && !is_array) {
      if (tree.children.size() > found->second.size())
        fail("line {}: {} has {} values and {} fields", tree.line, path, tree.children.size(), found->second.size());
      for (std::size_t i = 0; i < tree.children.size(); ++i) {
        const ReadField& field = found->second[i];
        flatten(path + "." + field.name, field.type, field.is_array, tree.children[i]);
      }
      return;
    }
    ReadConstant constant{path, {}, {}, tree.line};
    if (!shape_of(tree, 0, constant.shape)) fail("line {}: the rows of {} differ in length", tree.line, path);
    values_of(tree, constant.values);
    text_.constants.push_back(std::move(constant));
  }

  /// "Dense<float, 2, 4>" as its parts.
  void add_type(const std::string& path, const std::vector<Token>& type, int line) {
    ReadConstant constant{path, {}, {}, line};
    std::string part;
    std::size_t at = 0;
    int depth = 0;
    const auto end_part = [&] {
      if (!part.empty()) constant.values.push_back({part, line, at});
      part.clear();
    };
    for (const Token& token : type) {
      if (is_qualifier(token.text)) continue;
      const bool opens = token.is("<"), closes = token.is(">");
      if (closes) --depth;
      if ((depth == 0 && (opens || closes)) || (depth == 1 && token.is(","))) {
        end_part();
      } else {
        if (part.empty()) at = token.at;
        part += token.text;
      }
      if (opens) ++depth;
    }
    end_part();
    constant.shape = {constant.values.size()};
    text_.constants.push_back(std::move(constant));
  }

  std::optional<long> integer(const std::vector<Token>& expression) const { return integer_of(expression, integers_); }
  long needed(const std::vector<Token>& expression, const Token& of) const {
    const std::optional<long> value = integer(expression);
    if (!value) fail("line {}: {} = {} cannot be told as an integer", of.line, of.text, text_of(expression));
    return *value;
  }

  TokenStream in_;
  bool in_namespace_ = false;
  std::string prefix_;
  std::map<std::string, Fields> structures_;
  std::map<std::string, long> integers_;
  std::set<std::string> tables_;
  ReadText text_;
};

}  // namespace

ReadText read_text(std::string_view text, const std::string& name) {
  return Reader(text, name).all();
}

}  // namespace nlo::codegen
