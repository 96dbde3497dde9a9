#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

#include "tests/core/effects/made_textures.h"

namespace hapton::made {

inline std::string value_list(const char* name, const std::vector<double>& values) {
  std::string text = fmt::format("      <{}>\n", name);
  for (const double value : values) text += fmt::format("         <value>{:.9f}</value>\n", value);
  return text + fmt::format("      </{}>\n", name);
}

// Models in the file format of the Penn Haptic Texture Toolkit, including the elements that Hapton does not use.
inline std::string texture_file(const std::vector<TextureModel>& models, const std::vector<TextureTriangle>& triangles,
                                double rate_hz = 1000.0) {
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<modelSet texture=\"7\">\n   <material>Made Up</material>\n"
      "   <AccelUnits>m/s^2</AccelUnits>\n   <SpeedUnits>mm/s</SpeedUnits>\n   <ForceUnits>N</ForceUnits>\n"
      "   <SampleRate>{:g}</SampleRate>\n   <mu>0.25</mu>\n   <renderPicture>none.bmp</renderPicture>\n"
      "   <numMod>{}</numMod>\n   <numTri>{}</numTri>\n",
      rate_hz, models.size(), triangles.size());
  for (const TextureTriangle& triangle : triangles) {
    text += "   <tri type=\"array\">\n";
    for (const std::size_t corner : triangle) text += fmt::format("      <value>{}</value>\n", corner + 1);
    text += "   </tri>\n";
  }
  text +=
      fmt::format("   <numARCoeff>{}</numARCoeff>\n   <numMACoeff>{}</numMACoeff>\n", models.front().ar.size(), models.front().ma.size());
  for (const TextureModel& model : models) {
    text += "   <model>\n" + value_list("ARcoeff", coefficients(model.ar)) + value_list("ARlsf", model.ar);
    text += value_list("MAcoeff", coefficients(model.ma)) + value_list("MAlsf", model.ma);
    text += fmt::format("      <var>{:.9f}</var>\n      <gain>{:.9f}</gain>\n", model.variance, model.gain);
    text += fmt::format("      <speedMod>{:.9f}</speedMod>\n      <forceMod>{:.9f}</forceMod>\n   </model>\n", 1000.0 * model.speed_m_per_s,
                        model.force_n);
  }
  return text + "</modelSet>\n";
}

inline std::string texture_file() { return texture_file(nine_models(20, 18), eight_triangles()); }

}  // namespace hapton::made
