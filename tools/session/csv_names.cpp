#include "tools/session/csv_names.h"

#include "scene/text_cursor.h"

namespace hapton {
namespace {

std::string csv_text(const std::string& text) { return csv_cell(whole_text(text)); }

}  // namespace

std::string whole_text(std::string_view text) { return printable(text, text.size()); }

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string csv_names(std::span<const ObjectName> names, int object) {
  if (object < 0 || object >= static_cast<int>(names.size())) return ",";
  const ObjectName& name = names[static_cast<std::size_t>(object)];
  return csv_text(name.object) + "," + csv_text(name.material);
}

}  // namespace hapton
