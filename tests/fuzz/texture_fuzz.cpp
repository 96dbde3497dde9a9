// Any bytes as a file of recorded texture models: they give a one-line error, or models whose numbers are always finite.
#include <cmath>
#include <string_view>

#include "scene/texture_file.h"
#include "tests/fuzz/fuzz_target.h"

FUZZ_TARGET(texture) {
  using namespace hapton;
  const auto read = parse_texture({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (!read) {
    fuzz::require(!read.error().what.empty());
    fuzz::require(read.error().what.find('\n') == std::string::npos);
    return;
  }
  TextureModels::Blend blend;
  std::size_t triangle = 0;
  for (const double speed_m_per_s : {0.0, 0.1, 1e9}) {
    read->blend(speed_m_per_s, 0.01 * speed_m_per_s, triangle, blend);
    fuzz::require(std::isfinite(blend.deviation));
    for (const double coefficient : read->ar(blend)) fuzz::require(std::isfinite(coefficient));
  }
}
