#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/result.h"

// Values of a glTF document, whose types a file may have wrong. where: the place in the file that an error names.
namespace hapton::gltf {

using Json = nlohmann::json;

constexpr std::string_view kExportAgain = "export the file again";

// A member of a JSON object; a null value when the object lacks it or is none.
const Json& member(const Json& object, const char* key);

// The extension of that name on a node, a primitive or a buffer view; null when it has none.
const Json& extension_of(const Json& object, const char* name);

std::size_t size_of_array(const Json& array);
std::string text_of(const Json& value);

// A whole number from 0 to 2^53.
Result<std::size_t> count_of(const Json& value, const std::string& where);
Result<std::size_t> count_or(const Json& value, std::size_t absent, const std::string& where);

// An index into one of the file's top-level arrays.
Result<std::size_t> index_of(const Json& value, const Json& array, const std::string& where);

template <std::size_t N>
Result<std::array<double, N>> numbers_of(const Json& value, const std::string& where) {
  std::array<double, N> numbers = {};
  if (size_of_array(value) != N) return fail("{} does not have {} numbers: {}", where, N, kExportAgain);
  for (std::size_t i = 0; i < N; ++i) {
    if (!value[i].is_number()) return fail("{} holds something that is not a number: {}", where, kExportAgain);
    numbers[i] = value[i].get<double>();
    if (!std::isfinite(numbers[i])) return fail("{} is not finite: {}", where, kExportAgain);
  }
  return numbers;
}

}  // namespace hapton::gltf
