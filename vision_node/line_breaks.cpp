#include "vision_node/line_breaks.h"

#include <vector>

namespace hapton {
namespace {

using Fits = std::function<bool(std::string_view)>;

std::vector<std::string_view> split(std::string_view text, std::string_view gap) {
  std::vector<std::string_view> parts;
  for (std::size_t at = text.find(gap); at != std::string_view::npos; at = text.find(gap)) {
    parts.push_back(text.substr(0, at));
    text.remove_prefix(at + gap.size());
  }
  parts.push_back(text);
  return parts;
}

// Puts as many parts into each line as fit.
std::vector<std::string> pack(std::string_view text, std::string_view gap, const Fits& fits) {
  std::vector<std::string> lines;
  for (const std::string_view part : split(text, gap)) {
    std::string longer = lines.empty() ? std::string() : lines.back() + std::string(gap) + std::string(part);
    if (!lines.empty() && fits(longer)) {
      lines.back() = std::move(longer);
    } else {
      lines.emplace_back(part);
    }
  }
  return lines;
}

}  // namespace

std::string break_lines(std::string_view text, const Fits& fits) {
  std::string broken;
  const auto add = [&](std::string_view line) { broken += std::string(line) + "\n"; };
  for (const std::string_view line : split(text, "\n")) {
    if (fits(line)) {
      add(line);
      continue;
    }
    for (const std::string& entries : pack(line, "   ", fits)) {
      if (fits(entries)) {
        add(entries);
      } else {
        for (const std::string& words : pack(entries, " ", fits)) add(words);
      }
    }
  }
  broken.pop_back();
  return broken;
}

}  // namespace hapton
