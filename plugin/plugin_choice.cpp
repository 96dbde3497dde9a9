#include "plugin/plugin_choice.h"

#include <algorithm>

namespace hapton {
namespace {

// Where the parameters begin: at the last colon before the first "=". A path may hold colons.
std::size_t find_parameters(std::string_view text) {
  const std::size_t sign = text.find('=');
  return sign == std::string_view::npos ? sign : text.rfind(':', sign);
}

}  // namespace

std::string PluginChoice::to_text() const {
  std::string text = file;
  for (const auto& [key, value] : parameters) text += (text.size() == file.size() ? ":" : ",") + key + "=" + value;
  return text;
}

Result<PluginChoice> parse_plugin_choice(std::string_view text) {
  PluginChoice choice;
  const std::size_t colon = find_parameters(text);
  choice.file = text.substr(0, colon);
  if (choice.file.empty()) return fail("plug-in '{}': it names no file; write FILE.so or FILE.so:KEY=VALUE,KEY=VALUE", text);
  if (colon == std::string_view::npos) {
    if (const std::size_t end = text.find(".so:"); end != std::string_view::npos) {
      return fail("plug-in '{}': '{}' has no value; write KEY=VALUE", text, text.substr(end + 4));
    }
    return choice;
  }
  std::string_view rest = text.substr(colon + 1);
  for (bool is_last = false; !is_last;) {
    const std::size_t comma = rest.find(',');
    is_last = comma == std::string_view::npos;
    const std::string_view word = rest.substr(0, comma);
    if (!is_last) rest.remove_prefix(comma + 1);
    const std::size_t sign = word.find('=');
    if (sign == std::string_view::npos || sign == 0) return fail("plug-in '{}': '{}' is not a parameter; write KEY=VALUE", text, word);
    const std::string key(word.substr(0, sign));
    if (std::ranges::any_of(choice.parameters, [&](const auto& known) { return known.first == key; }))
      return fail("plug-in '{}': '{}' is given twice; leave one out", text, key);
    choice.parameters.emplace_back(key, word.substr(sign + 1));
  }
  return choice;
}

}  // namespace hapton
