#include "runtime/flag_checks.h"

#include <fmt/core.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <system_error>

#include "runtime/writable_path.h"

namespace hapton {
namespace {

std::optional<double> find_number(const std::string& text) {
  double value = 0.0;
  return CLI::detail::lexical_cast(text, value) ? std::optional(value) : std::nullopt;
}

// Rejects text that is not a number, and numbers for which `rejection` returns a reason; `advice` ends both error messages.
template <class Rejection>
CLI::Validator check_number(Rejection rejection, const std::string& advice, const std::string& type_name) {
  return CLI::Validator(
      [rejection, advice](std::string& text) {
        const auto value = find_number(text);
        const std::string wrong = value ? rejection(*value) : "is not a number";
        return wrong.empty() ? std::string() : fmt::format("{} {}; give {}", text.empty() ? "''" : text, wrong, advice);
      },
      type_name);
}

}  // namespace

// Written so that nan, which lies in no range, is rejected too.
CLI::Validator between(double least, double most) {
  const auto rejection = [least, most](double value) -> std::string { return value >= least && value <= most ? "" : "is out of range"; };
  return check_number(rejection, fmt::format("{} to {}", least, most), fmt::format("[{}, {}]", least, most));
}

CLI::Validator above_zero(const std::string& what) {
  return check_number([](double value) { return std::string(value > 0.0 ? "" : "is not above zero"); }, what + " above zero", "POSITIVE");
}

CLI::Validator zero_or_more(const std::string& what) {
  const auto rejection = [](double value) -> std::string {
    if (value < 0.0) return "is below zero";
    return value >= 0.0 ? "" : "is not a number";
  };
  return check_number(rejection, what + ", zero or more", "NONNEGATIVE");
}

CLI::Validator whole_number(std::int64_t least, std::uint64_t most) {
  return CLI::Validator(
      [least, most](std::string& text) -> std::string {
        const auto number = find_number(text);
        if (!number || !std::isfinite(*number)) return {};
        const bool is_negative = text.starts_with('-');
        std::string_view digits = std::string_view(text).substr(is_negative || text.starts_with('+') ? 1 : 0);
        const bool is_hexadecimal = digits.starts_with("0x") || digits.starts_with("0X");
        if (is_hexadecimal) digits.remove_prefix(2);
        std::uint64_t size = 0;
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), size, is_hexadecimal ? 16 : 10);
        const std::string advice = fmt::format("give a whole number from {} to {}", least, most);
        if (end != digits.data() + digits.size()) return fmt::format("{} is not a whole number in digits; {}", text, advice);
        if (!is_hexadecimal && digits.size() > 1 && digits.front() == '0')
          return fmt::format("{} begins with a zero; {}, without it", text, advice);
        const std::uint64_t most_size = is_negative ? std::uint64_t{0} - static_cast<std::uint64_t>(least) : most;
        const bool fits = error == std::errc() && size <= most_size;
        return fits ? std::string() : fmt::format("{} is out of range; {}", text, advice);
      },
      "");
}

CLI::Validator folder_to_write() {
  return CLI::Validator(
      [](std::string& text) {
        const auto checked = check_writable_folder(text);
        return checked ? std::string() : checked.error().what;
      },
      "");
}

CLI::Validator file_to_write() {
  return CLI::Validator(
      [](std::string& text) {
        const auto checked = check_writable_file(text);
        return checked ? std::string() : checked.error().what;
      },
      "");
}

}  // namespace hapton
