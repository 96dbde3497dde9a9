#include "runtime/toml_reader.h"

#include <external/toml.h>
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "runtime/regular_file.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 20;

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

// The library reports errors by exceptions in this build.
Result<toml::table> parse(const std::filesystem::path& path, std::string_view text) {
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    return fail("{}:{}: {}", path.string(), error.source().begin.line, explain_toml_error(error.description()));
  }
}

}  // namespace

std::string explain_toml_error(std::string_view words) {
  const std::string text = one_line(std::string(words));
  return text.find("utf-8") != text.npos ? text + "; save the file as UTF-8" : text;
}

struct TomlReader::File {
  std::filesystem::path path;
  toml::table root;
  std::optional<Error> error;
};

struct TomlReader::Table {
  std::shared_ptr<File> file;
  const toml::table* keys = nullptr;
  std::string where;  // "[[device]] 2"; empty for the file itself

  const toml::node* find(std::string_view key) const { return file->error ? nullptr : keys->get(key); }

  std::string in_where() const { return where.empty() ? "" : " in " + where; }

  // "'key' in [[device]] 2 must be ..."
  template <class... Args>
  void fail_at(const toml::node& node, fmt::format_string<Args...> format, Args&&... args) const {
    if (file->error) return;
    const std::string what = one_line(fmt::format(format, std::forward<Args>(args)...));
    file->error = Error{fmt::format("{}:{}: {}", file->path.string(), node.source().begin.line, what)};
  }

  std::optional<double> number_of(const toml::node& node, std::string_view what, double least, double most) const {
    const auto number = node.is_number() ? node.value<double>() : std::nullopt;
    if (!number) {
      fail_at(node, "{}{} must be a number", what, in_where());
    } else if (!(*number >= least && *number <= most)) {
      fail_at(node, "{}{} is {}: it must be at least {} and at most {}", what, in_where(), *number, least, most);
    } else {
      return number;
    }
    return std::nullopt;
  }
};

Result<TomlReader> TomlReader::open(const std::filesystem::path& path) {
  const auto text = read_regular_file(path, "a TOML file is expected at this path", kMaxBytes);
  if (!text) return tl::unexpected(text.error());
  auto parsed = parse(path, *text);
  if (!parsed) return tl::unexpected(parsed.error());
  auto file = std::make_shared<File>(File{path, std::move(*parsed), {}});
  const toml::table* root = &file->root;
  return TomlReader(std::make_shared<const Table>(Table{std::move(file), root, ""}));
}

void TomlReader::allow(std::initializer_list<std::string_view> known) {
  for (const auto& [key, node] : *table_->keys) {
    if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
    table_->fail_at(node, "unknown key '{}'{}; known are {}", key.str(), table_->in_where(), fmt::join(known, ", "));
  }
}

void TomlReader::require(std::string_view key) {
  if (table_->find(key) == nullptr) table_->fail_at(*table_->keys, "'{}' is missing{}; add it", key, table_->in_where());
}

bool TomlReader::has(std::string_view key) const { return table_->find(key) != nullptr; }

void TomlReader::read(std::string_view key, std::string& value) {
  const toml::node* node = table_->find(key);
  if (node == nullptr) return;
  const auto text = node->value_exact<std::string>();
  if (!text) return table_->fail_at(*node, "'{}'{} must be a text in quotes", key, table_->in_where());
  value = *text;
}

void TomlReader::read(std::string_view key, bool& value) {
  const toml::node* node = table_->find(key);
  if (node == nullptr) return;
  const auto flag = node->value_exact<bool>();
  if (!flag) return table_->fail_at(*node, "'{}'{} must be true or false", key, table_->in_where());
  value = *flag;
}

void TomlReader::read(std::string_view key, double& value, double least, double most) {
  const toml::node* node = table_->find(key);
  if (node == nullptr) return;
  if (const auto number = table_->number_of(*node, fmt::format("'{}'", key), least, most)) value = *number;
}

void TomlReader::read(std::string_view key, std::int64_t& value, std::int64_t least, std::int64_t most) {
  const toml::node* node = table_->find(key);
  if (node == nullptr) return;
  const auto number = node->value_exact<std::int64_t>();
  if (!number) return table_->fail_at(*node, "'{}'{} must be a whole number", key, table_->in_where());
  if (*number < least || *number > most) {
    return table_->fail_at(*node, "'{}'{} is {}: it must be at least {} and at most {}", key, table_->in_where(), *number, least, most);
  }
  value = *number;
}

void TomlReader::read(std::string_view key, Vec3& value, double least, double most) {
  const toml::node* node = table_->find(key);
  if (node == nullptr) return;
  const toml::array* array = node->as_array();
  if (array == nullptr || array->size() != 3) return table_->fail_at(*node, "'{}'{} must be a list of 3 numbers", key, table_->in_where());
  Vec3 read = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const auto number =
        table_->number_of(*array->get(static_cast<std::size_t>(axis)), fmt::format("number {} of '{}'", axis + 1, key), least, most);
    if (!number) return;
    read[axis] = *number;
  }
  value = read;
}

void TomlReader::read_path(std::string_view key, std::string& value) {
  if (!has(key)) return;
  std::string path;
  read(key, path);
  if (table_->file->error) return;
  if (path.empty()) return reject(key, fmt::format("'{}'{} is empty: name a file or leave it out", key, table_->in_where()));
  value = (table_->file->path.parent_path() / path).lexically_normal().string();
}

std::vector<TomlReader> TomlReader::tables(std::string_view key) {
  std::vector<TomlReader> readers;
  const toml::node* node = table_->find(key);
  if (node == nullptr) return readers;
  const toml::array* array = node->as_array();
  if (array == nullptr || !array->is_array_of_tables()) {
    table_->fail_at(*node, "'{}'{} must be tables, each begun by a line [[{}]]", key, table_->in_where(), key);
    return readers;
  }
  for (const toml::node& element : *array) {
    const std::string where = fmt::format("[[{}]] {}", key, readers.size() + 1);
    readers.push_back(TomlReader(std::make_shared<const Table>(Table{table_->file, element.as_table(), where})));
  }
  return readers;
}

TomlReader TomlReader::table(std::string_view key) {
  static const auto& none = *new toml::table;  // never destroyed: a thread of StoppableCalls may use it while the program ends
  const toml::node* node = table_->find(key);
  if (node != nullptr && !node->is_table())
    table_->fail_at(*node, "'{}'{} must be a table, begun by a line [{}]", key, table_->in_where(), key);
  const toml::table* keys = node != nullptr && node->is_table() ? node->as_table() : &none;
  return TomlReader(std::make_shared<const Table>(Table{table_->file, keys, fmt::format("[{}]", key)}));
}

void TomlReader::reject(std::string_view key, std::string_view what) {
  const toml::node* node = table_->find(key);
  table_->fail_at(node == nullptr ? static_cast<const toml::node&>(*table_->keys) : *node, "{}", what);
}

Result<void> TomlReader::result() const {
  if (table_->file->error) return tl::unexpected(*table_->file->error);
  return {};
}

}  // namespace hapton
