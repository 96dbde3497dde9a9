#pragma once

#include <chrono>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <thread>

#include <gtest/gtest.h>

#include "vision_node/stereo_view.h"

namespace hapton {

// A ball whose triangles face outwards.
inline std::shared_ptr<const TriangleMesh> make_marker(const Vec3& centre, double radius_m) {
  constexpr std::uint32_t kSides = 24;
  auto mesh = std::make_shared<TriangleMesh>();
  for (std::uint32_t i = 0; i <= kSides; ++i) {
    for (std::uint32_t j = 0; j < kSides; ++j) {
      const double polar = std::numbers::pi * i / kSides;
      const double azimuth = 2.0 * std::numbers::pi * j / kSides;
      mesh->vertices.push_back(centre +
                               radius_m * Vec3(std::sin(polar) * std::sin(azimuth), std::cos(polar), std::sin(polar) * std::cos(azimuth)));
    }
  }
  for (std::uint32_t i = 0; i < kSides; ++i) {
    for (std::uint32_t j = 0; j < kSides; ++j) {
      const std::uint32_t a = i * kSides + j;
      const std::uint32_t b = i * kSides + (j + 1) % kSides;
      mesh->triangles.push_back({a, a + kSides, b + kSides});
      mesh->triangles.push_back({a, b + kSides, b});
    }
  }
  return mesh;
}

// A window for measuring: unlit colours on black, no HUD.
inline ViewSettings plain_settings(StereoMode mode, int width_px, int height_px) {
  ViewSettings settings;
  settings.stereo = mode;
  settings.width_px = width_px;
  settings.height_px = height_px;
  settings.offscreen = true;
  settings.plain = true;
  settings.framing = frame_sphere(Vec3::Zero(), 0.12, 0.063);
  return settings;
}

inline std::unique_ptr<StereoView> open_or_fail(const ViewSettings& settings, const std::vector<ShownObject>& objects) {
  auto view = StereoView::open(settings, objects);
  if (!view) {
    ADD_FAILURE() << view.error().what;
    return nullptr;
  }
  return std::move(*view);
}

// Waits five minutes at most: levels are made at the lowest priority, and other programs may be running.
inline void wait_for_levels(StereoView& view) {
  for (int waits = 0; waits < 30'000 && view.detail_progress() < 1.0; ++waits) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ASSERT_EQ(view.detail_progress(), 1.0);
}

// Mean pixel of the columns [from, to), weighted by one colour channel, counted from their lower left corner; nothing if all is black.
inline std::optional<Vec2> centroid(const Picture& picture, int channel, int from, int to) {
  double sum = 0.0;
  Vec2 at = Vec2::Zero();
  for (int y = 0; y < picture.size.height_px; ++y) {
    for (int x = from; x < to; ++x) {
      const double weight = picture.at(x, y)[channel];
      sum += weight;
      at += weight * Vec2(x - from + 0.5, y + 0.5);
    }
  }
  if (sum == 0.0) return std::nullopt;
  return at / sum;
}

}  // namespace hapton
