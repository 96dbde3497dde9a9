#include "scene/texture_file.h"

#include <tinyxml2.h>

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene/file_bytes.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

using Element = tinyxml2::XMLElement;

// The largest file of the Haptic Texture Toolkit has 184 kB.
constexpr std::size_t kMaxTextureFileBytes = std::size_t{1} << 22;
constexpr double kMmPerM = 1000.0;
constexpr double kMaxTextureCount = 1000.0;

// Reads elements. Keeps the first error; a value that cannot be read is 0 or empty.
class TextureXml {
 public:
  const std::optional<Error>& error() const { return error_; }

  // Null, with an error: there is no such element.
  const Element* child(const Element& parent, const char* name) {
    const Element* found = parent.FirstChildElement(name);
    if (found == nullptr) set_error(parent, "<{}> has no <{}>: export it again", printable(parent.Name()), name);
    return found;
  }

  std::string_view text(const Element& element) {
    const char* text = element.GetText();
    TextCursor cursor(text == nullptr ? "" : text);
    const std::string_view word = cursor.word();
    return cursor.word().empty() ? word : std::string_view();
  }

  double number(const Element& element) {
    double value = 0.0;
    if (!parse_number(text(element), value) || !std::isfinite(value)) {
      const char* given = element.GetText();
      set_error(element, "<{}> is '{}': it must be a finite number", printable(element.Name()), printable(given == nullptr ? "" : given));
      return 0.0;
    }
    return value;
  }
  double number(const Element& parent, const char* name) {
    const Element* found = child(parent, name);
    return found == nullptr ? 0.0 : number(*found);
  }

  std::size_t count(const Element& parent, const char* name) {
    const Element* found = child(parent, name);
    if (found == nullptr) return 0;
    const double value = number(*found);
    if (value >= 0.0 && value <= kMaxTextureCount && value == std::trunc(value)) return static_cast<std::size_t>(value);
    set_error(*found, "<{}> is {}: it must be a whole number from 0 to {}", name, value, kMaxTextureCount);
    return 0;
  }

  // All <value>s of an element.
  std::vector<double> values(const Element& list) {
    std::vector<double> values;
    for (const Element* one = list.FirstChildElement("value"); one != nullptr && !error_; one = one->NextSiblingElement("value")) {
      values.push_back(number(*one));
    }
    return values;
  }
  std::vector<double> values(const Element& parent, const char* name, std::size_t count, const char* count_name) {
    const Element* list = child(parent, name);
    if (list == nullptr) return {};
    std::vector<double> found = values(*list);
    expect_count(*list, found.size(), "<value>s", count, count_name);
    return found;
  }

  void expect_count(const Element& where, std::size_t found, std::string_view what, std::size_t expected, const char* count_name) {
    if (found != expected) set_error(where, "there are {} {}, but <{}> is {}: export it again", found, what, count_name, expected);
  }

  // A unit that is not given is the one that the toolkit uses.
  void expect_unit(const Element& set, const char* name, std::string_view unit) {
    const Element* found = set.FirstChildElement(name);
    if (found != nullptr && text(*found) != unit) {
      set_error(*found, "<{}> is '{}': convert the models to {}", name, printable(text(*found)), unit);
    }
  }

  template <class... Args>
  void set_error(const Element& element, fmt::format_string<Args...> format, Args&&... args) {
    if (error_) return;
    error_ = Error{fmt::format("line {}: ", element.GetLineNum()) + fmt::format(format, std::forward<Args>(args)...)};
  }

 private:
  std::optional<Error> error_;
};

std::vector<TextureModel> read_texture_models(TextureXml& xml, const Element& set) {
  const std::size_t ar = xml.count(set, "numARCoeff");
  const std::size_t ma = xml.count(set, "numMACoeff");
  std::vector<TextureModel> models;
  for (const Element* one = set.FirstChildElement("model"); one != nullptr && !xml.error(); one = one->NextSiblingElement("model")) {
    TextureModel model;
    model.speed_m_per_s = xml.number(*one, "speedMod") / kMmPerM;
    model.force_n = xml.number(*one, "forceMod");
    model.ar = xml.values(*one, "ARlsf", ar, "numARCoeff");
    // In the toolkit, the gain belongs to the moving-average (MA) part.
    if (ma > 0) {
      model.ma = xml.values(*one, "MAlsf", ma, "numMACoeff");
      model.gain = xml.number(*one, "gain");
    }
    model.variance = xml.number(*one, "var");
    models.push_back(std::move(model));
  }
  xml.expect_count(set, models.size(), "<model>s", xml.count(set, "numMod"), "numMod");
  return models;
}

std::vector<TextureTriangle> read_texture_triangles(TextureXml& xml, const Element& set, std::size_t models) {
  std::vector<TextureTriangle> triangles;
  for (const Element* one = set.FirstChildElement("tri"); one != nullptr && !xml.error(); one = one->NextSiblingElement("tri")) {
    const std::vector<double> corners = xml.values(*one);
    if (corners.size() != 3) {
      xml.set_error(*one, "<tri> has {} <value>s: give the numbers of three models", corners.size());
      break;
    }
    TextureTriangle triangle = {};
    for (std::size_t k = 0; k < 3; ++k) {
      if (!(corners[k] >= 1.0 && corners[k] <= static_cast<double>(models) && corners[k] == std::trunc(corners[k]))) {
        xml.set_error(*one, "<tri> names model {}: give numbers from 1 to {}", corners[k], models);
        return triangles;
      }
      triangle[k] = static_cast<std::size_t>(corners[k]) - 1;
    }
    triangles.push_back(triangle);
  }
  xml.expect_count(set, triangles.size(), "<tri>s", xml.count(set, "numTri"), "numTri");
  return triangles;
}

}  // namespace

Result<TextureModels> parse_texture(std::string_view text) {
  tinyxml2::XMLDocument document;
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    return fail("line {}: is not XML ({}): export it again", document.ErrorLineNum(), document.ErrorName());
  }
  const Element* set = document.RootElement();
  if (set == nullptr || std::string_view(set->Name()) != "modelSet") {
    return fail("is not a texture of the Haptic Texture Toolkit: its root is <{}>, not <modelSet>",
                set == nullptr ? "" : printable(set->Name()));
  }
  TextureXml xml;
  xml.expect_unit(*set, "AccelUnits", "m/s^2");
  xml.expect_unit(*set, "SpeedUnits", "mm/s");
  xml.expect_unit(*set, "ForceUnits", "N");
  const double rate_hz = xml.number(*set, "SampleRate");
  std::vector<TextureModel> models = read_texture_models(xml, *set);
  std::vector<TextureTriangle> triangles = read_texture_triangles(xml, *set, models.size());
  if (xml.error()) return tl::unexpected(*xml.error());
  return TextureModels::make(rate_hz, std::move(models), std::move(triangles));
}

Result<TextureModels> read_texture_file(const std::filesystem::path& path) {
  const Result<std::string> bytes = read_file_bytes(path, kMaxTextureFileBytes);
  if (!bytes) return tl::unexpected(bytes.error());
  auto models = parse_texture(*bytes);
  if (!models) return fail("{}: {}", path.string(), models.error().what);
  return models;
}

}  // namespace hapton
