#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/math/types.h"

namespace hapton {

// The parser's message about a file that is not TOML, in one line, with the remedy for text in another encoding.
std::string explain_toml_error(std::string_view words);

// One table of a TOML file, read strictly and key by key: an unknown key, a wrong type or a value out of range is an error
// with file and line. The first error of the file is kept and all reads after it do nothing, so a caller checks once, at
// the end. A missing key leaves the value unchanged, except for require. Pre: ranges are finite. RT: set-up only. Threads:
// one.
class TomlReader {
 public:
  // The top-level table of a file. Error: it cannot be read, is larger than 1 MiB, or is not TOML.
  static Result<TomlReader> open(const std::filesystem::path& path);

  // Declares the known keys: any other key is an error that lists them.
  void allow(std::initializer_list<std::string_view> known);
  void require(std::string_view key);
  bool has(std::string_view key) const;

  void read(std::string_view key, std::string& value);
  void read(std::string_view key, bool& value);
  void read(std::string_view key, double& value, double least, double most);
  void read(std::string_view key, std::int64_t& value, std::int64_t least, std::int64_t most);
  void read(std::string_view key, Vec3& value, double least, double most);
  // A relative path starts at the folder of the TOML file.
  void read_path(std::string_view key, std::string& value);

  // The tables of [[key]]; empty if there are none.
  std::vector<TomlReader> tables(std::string_view key);
  // The table [key]; an empty one if there is none.
  TomlReader table(std::string_view key);

  // Reports an error that the caller found, at this key (or at the table, if it has no such key).
  void reject(std::string_view key, std::string_view what);

  // Error: the first of the whole file, "FILE:LINE: what".
  Result<void> result() const;

 private:
  struct File;
  struct Table;
  explicit TomlReader(std::shared_ptr<const Table> table) : table_(std::move(table)) {}

  std::shared_ptr<const Table> table_;
};

}  // namespace hapton
