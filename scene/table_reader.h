#pragma once

#define TOML_EXCEPTIONS 0
#include <external/toml.h>
#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/result.h"
#include "core/base/similar_word.h"
#include "core/math/types.h"
#include "scene/text_cursor.h"

namespace hapton {

// "line N: " for a node read from a file; empty for a generated one.
inline std::string line_prefix(const toml::node& node) {
  const auto line = node.source().begin.line;
  return line == 0 ? std::string() : fmt::format("line {}: ", line);
}

// Error: one line with the line in the text.
inline Result<toml::table> parse_toml(std::string_view text) {
  toml::parse_result parsed = toml::parse(text);
  if (parsed) return std::move(parsed).table();
  std::string what(parsed.error().description());
  std::replace(what.begin(), what.end(), '\n', ' ');
  if (what.find("utf-8") != what.npos) what += ": save the file as UTF-8";
  return fail("line {}: {}", parsed.error().source().begin.line, what);
}

// Reads typed values from one table, which must outlive it. The first error is kept, and later values are not read. An error is one line:
// the line in the file, the key and the table, what is wrong with the value and which ones are allowed. RT: set-up only.
class TableReader {
 public:
  TableReader(const toml::table& table, std::string where) : table_(table), where_(std::move(where)) {}

  const std::optional<Error>& error() const { return error_; }

  void allow(std::initializer_list<std::string_view> known) { allow(std::span(known.begin(), known.size())); }
  void allow(std::span<const std::string_view> known) {
    for (const auto& [key, node] : table_) {
      if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
      set_error(node, "unknown key '{}' in {}{}", printable(key.str()), where_, similar_word_hint(key.str(), known));
    }
  }

  const std::string& where() const { return where_; }  // the table as errors name it: "[[object]] 2"
  bool has(std::string_view key) const { return table_.contains(key); }

  void read(std::string_view key, std::string& value) {
    if (const toml::node* node = find(key)) {
      if (const auto text = node->value_exact<std::string>())
        value = *text;
      else
        set_error(*node, "'{}' in {} must be a text in quotes", key, where_);
    }
  }

  // A text without control characters, which logs, terminals and messages show unchanged.
  void read_name(std::string_view key, std::string& value) {
    read(key, value);
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
    if (!error() && std::any_of(value.begin(), value.end(), is_control)) {
      fail_at(key, "'{}' in {} is '{}', with a control character: leave it out", key, where_, printable(value));
    }
  }

  void read(std::string_view key, bool& value) {
    if (const toml::node* node = find(key)) {
      if (const auto flag = node->value_exact<bool>())
        value = *flag;
      else
        set_error(*node, "'{}' in {} must be true or false", key, where_);
    }
  }

  // above: the lower bound itself is not allowed.
  void read(std::string_view key, double& value, double least, double most, bool above = false) {
    if (const toml::node* node = find(key)) read_number(*node, fmt::format("'{}'", key), value, least, most, above);
  }

  template <std::size_t N>
  void read(std::string_view key, std::array<double, N>& values, double least, double most) {
    const toml::node* node = find(key);
    if (node == nullptr) return;
    const toml::array* array = node->as_array();
    if (array == nullptr || array->size() != N) return set_error(*node, "'{}' in {} must be a list of {} numbers", key, where_, N);
    for (std::size_t i = 0; i < N; ++i)
      read_number(*array->get(i), fmt::format("number {} of '{}'", i + 1, key), values[i], least, most, false);
  }

  // A vector with coordinates within +- most.
  void read(std::string_view key, Vec3& value, double most) {
    std::array<double, 3> numbers = {value.x(), value.y(), value.z()};
    read(key, numbers, -most, most);
    value = Vec3(numbers[0], numbers[1], numbers[2]);
  }

  // A direction of any length except zero, normalised.
  void read_direction(std::string_view key, Vec3& value) {
    if (!has(key)) return;
    Vec3 given = Vec3::Zero();
    read(key, given, kMaxDirection);
    if (error_) return;
    if (!(given.norm() > 0.0)) return fail_at(key, "'{}' in {} has length 0: give a direction", key, where_);
    value = given.normalized();
  }

  // One of the names; sets `value` to its index.
  void read_choice(std::string_view key, std::span<const std::string_view> names, std::size_t& value) {
    std::string name;
    read(key, name);
    if (error_ || !has(key)) return;
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) {
      return fail_at(key, "'{}' in {} is '{}': choose one of {}", key, where_, printable(name), fmt::join(names, ", "));
    }
    value = static_cast<std::size_t>(found - names.begin());
  }

  void require(std::string_view key) {
    if (!has(key)) fail_at(key, "{} has no '{}': add it", where_, key);
  }

  template <class... Args>
  void fail_at(std::string_view key, fmt::format_string<Args...> format, Args&&... args) {
    const toml::node* node = table_.get(key);
    set_error(node == nullptr ? static_cast<const toml::node&>(table_) : *node, format, std::forward<Args>(args)...);
  }

 private:
  static constexpr double kMaxDirection = 1e6;

  const toml::node* find(std::string_view key) const { return error_ ? nullptr : table_.get(key); }

  void read_number(const toml::node& node, const std::string& what, double& value, double least, double most, bool above) {
    const auto number = node.value<double>();
    if (!number || !node.is_number()) return set_error(node, "{} in {} must be a number", what, where_);
    if (!(*number >= least && *number <= most) || (above && *number == least)) {
      return set_error(node, "{} in {} is {}: it must be {} {} and at most {}", what, where_, *number, above ? "above" : "at least", least,
                       most);
    }
    value = *number;
  }

  template <class... Args>
  void set_error(const toml::node& node, fmt::format_string<Args...> format, Args&&... args) {
    if (error_) return;
    error_ = Error{line_prefix(node) + fmt::format(format, std::forward<Args>(args)...)};
  }

  const toml::table& table_;
  std::string where_;
  std::optional<Error> error_;
};

}  // namespace hapton
