#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/result.h"

// Reads values of a glTF document, whose types may be wrong in the file. where: the place in the file, which an error message names.
namespace hapton::gltf {

using Json = nlohmann::json;

constexpr std::string_view kExportAgain = "export the file again";

// The member of a JSON object; a null value if the object has no such member, or if `object` is not an object.
const Json& member(const Json& object, const char* key);

// The extension of that name on a node, a primitive or a buffer view; null when it has none.
const Json& extension_of(const Json& object, const char* name);

std::size_t size_of_array(const Json& array);  // 0: not an array
std::string text_of(const Json& value);        // empty: not a string

// A whole number from 0 to 2^53 - 1. Error: the value is anything else. count_or: returns `absent` if the value is null.
Result<std::size_t> count_of(const Json& value, const std::string& where);
Result<std::size_t> count_or(const Json& value, std::size_t absent, const std::string& where);

// An index into `array`, one of the file's top-level arrays. Error: not a whole number, or out of range.
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
