#include "core/effects/mapped_spring.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <random>

namespace hapton {
namespace {

constexpr double kFullTurn = 2.0 * std::numbers::pi;

using Triangles = std::vector<MappedTriangle>;

// A rectangle in the plane z = 0, sheared into a parallelogram, with the whole image on it.
Triangles sheet(double width_m, double height_m, double shear_m = 0.0) {
  const Vec3 right(width_m, 0, 0);
  const Vec3 down(shear_m, height_m, 0);
  return {{{Vec3(0, 0, 0), right, Vec3(right + down)}, {Eigen::Vector2d(0, 0), {1, 0}, {1, 1}}},
          {{Vec3(0, 0, 0), Vec3(right + down), down}, {Eigen::Vector2d(0, 0), {1, 1}, {0, 1}}}};
}

template <class ValueAt>
std::shared_ptr<const SurfaceImage> image_of(int width, int height, ValueAt value_at) {
  std::vector<float> texels;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) texels.push_back(static_cast<float>(value_at((x + 0.5) / width, (y + 0.5) / height)));
  }
  return std::make_shared<const SurfaceImage>(width, height, std::move(texels));
}

std::shared_ptr<const SurfaceImage> noise(std::mt19937_64& random, int width, int height) {
  std::uniform_real_distribution<double> unit(0, 1);
  return image_of(width, height, [&](double, double) { return unit(random); });
}

// The second derivative of the map's number along the plane, from differences of its gradient.
Eigen::Matrix2d second_derivative(const ImageMap& map, const MapPlace& place, double step) {
  Eigen::Matrix2d found;
  for (int k = 0; k < 2; ++k) {
    const auto gradient_at = [&](double offset) {
      MapPlace moved = place;
      moved.texcoord += offset * Eigen::Vector2d(place.du[k], place.dv[k]);
      return Eigen::Vector2d(map.at(moved).gradient.head<2>());
    };
    found.col(k) = (gradient_at(step) - gradient_at(-step)) / (2.0 * step);
  }
  return 0.5 * (found + found.transpose());
}

double largest_eigenvalue_of(const Eigen::Matrix2d& matrix) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(matrix, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

TEST(MappedSpring, AWaveHasItsOwnCurvature) {
  const ImageMap map{
      .image = image_of(256, 1, [](double u, double) { return 0.5 + 0.5 * std::cos(kFullTurn * u); }), .at_black = -0.001, .at_white = 0.0};
  for (const double scale : {1e-6, 1.0, 1e6}) {
    const double expected = 0.5 * 0.001 * std::pow(kFullTurn / (0.02 * scale), 2);
    const double found = largest_curvature(map, sheet(0.02 * scale, 0.3 * scale));
    EXPECT_GT(found, 0.999 * expected) << scale;
    EXPECT_LT(found, 1.06 * expected) << scale;
  }
  const ImageMap grey{.image = image_of(3, 5, [](double, double) { return 0.5; }), .at_black = -0.001, .at_white = 0.0};
  EXPECT_LT(largest_curvature(grey, sheet(0.1, 0.1)), 1e-6);
  EXPECT_EQ(largest_curvature(grey, {}), 0.0);
}

// Brute-force twin: derivatives at places all over the image, on sheets that stretch and shear it.
TEST(MappedSpring, LargestCurvatureBoundsAllPlacesAndIsReached) {
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const bool is_reversed = seed % 2 == 0;
    const ImageMap map{.image = noise(random, 1 + static_cast<int>(random() % 12), 1 + static_cast<int>(random() % 12)),
                       .at_black = is_reversed ? 0.0 : -0.001,
                       .at_white = is_reversed ? -0.001 : 0.0};
    const double scale = std::pow(10.0, 8.0 * unit(random) - 4.0);
    const Triangles triangles = sheet(scale, scale * (0.1 + 10.0 * unit(random)), scale * (unit(random) - 0.5));
    MapPlace place = map_gradients(triangles[0]);
    double largest_sampled = 0.0;
    for (int n = 0; n < 20000; ++n) {
      place.texcoord = {unit(random), unit(random)};
      largest_sampled = std::max(largest_sampled, largest_eigenvalue_of(second_derivative(map, place, 1e-6 * scale)));
    }
    const double found = largest_curvature(map, triangles);
    EXPECT_GE(found, (1.0 - 1e-3) * largest_sampled) << "seed " << seed;
    EXPECT_LE(found, 1.25 * largest_sampled) << "seed " << seed;
  }
}

// A bump of one texel curves most in its middle, where its weight in the other direction of the image is 3/4. It must be found wherever it
// lies, along the rows and down the columns, on an image of more columns than rows.
TEST(MappedSpring, ABumpOfOneTexelIsFoundWhereverItLies) {
  constexpr int kWidth = 5;
  constexpr int kHeight = 4;
  for (const bool is_along_columns : {false, true}) {
    const Triangles triangles = is_along_columns ? sheet(1.0, 0.01) : sheet(0.01, 1.0);
    const double per_m = (is_along_columns ? kHeight : kWidth) / 0.01;
    const double expected = 0.75 * 2.0 * 0.001 * per_m * per_m;
    for (int bump = 0; bump < kWidth * kHeight; ++bump) {
      std::vector<float> texels(kWidth * kHeight, 0.0F);
      texels[static_cast<std::size_t>(bump)] = 1.0F;
      const auto image = std::make_shared<const SurfaceImage>(kWidth, kHeight, std::move(texels));
      const double found = largest_curvature({.image = image, .at_black = 0.0, .at_white = -0.001}, triangles);
      EXPECT_GE(found, (1.0 - 1e-9) * expected) << bump << " " << is_along_columns;
      EXPECT_LE(found, 1.1 * expected) << bump << " " << is_along_columns;
    }
  }
}

// Two texels that touch only at a corner are white, all others black: around that corner only the mixed derivative is large, and both of
// its signs count.
TEST(MappedSpring, ATwistIsFoundWhereverItLies) {
  constexpr int kSize = 6;
  for (const double white_m : {-0.001, 0.001}) {
    for (int corner = 0; corner < kSize * kSize; ++corner) {
      std::vector<float> texels(kSize * kSize, 0.0F);
      const int x = corner % kSize, y = corner / kSize;
      const auto at = [&](int i, int j) -> float& { return texels[static_cast<std::size_t>((y + j) % kSize * kSize + (x + i) % kSize)]; };
      at(0, 0) = at(1, 1) = 1.0F;
      const ImageMap map{
          .image = std::make_shared<const SurfaceImage>(kSize, kSize, std::move(texels)), .at_black = 0.0, .at_white = white_m};
      const Triangles triangles = sheet(0.01, 0.01);
      MapPlace place = map_gradients(triangles[0]);
      double largest_sampled = 0.0;
      for (int v = -20; v <= 40; ++v) {
        for (int u = -20; u <= 40; ++u) {
          place.texcoord = Eigen::Vector2d(x + 0.5 + 0.05 * u, y + 0.5 + 0.05 * v) / kSize;
          largest_sampled = std::max(largest_sampled, largest_eigenvalue_of(second_derivative(map, place, 1e-8)));
        }
      }
      const double found = largest_curvature(map, triangles);
      EXPECT_GE(found, (1.0 - 1e-3) * largest_sampled) << corner << " " << white_m;
      EXPECT_LE(found, 1.1 * largest_sampled) << corner << " " << white_m;
    }
  }
}

// The added stiffness is that of the steepest place beside the texel that differs; the slope across its edge is 3/4 of the step.
TEST(MappedSpring, AStepOfOneTexelIsFoundWhereverItLies) {
  constexpr int kWidth = 5;
  constexpr int kHeight = 4;
  for (const bool is_along_columns : {false, true}) {
    const Triangles triangles = is_along_columns ? sheet(10.0, 0.01) : sheet(0.01, 10.0);
    for (const bool is_soft : {false, true}) {
      for (int odd_texel = 0; odd_texel < kWidth * kHeight; ++odd_texel) {
        std::vector<float> texels(kWidth * kHeight, is_soft ? 1.0F : 0.0F);
        texels[static_cast<std::size_t>(odd_texel)] = is_soft ? 0.0F : 1.0F;
        const ImageMap share{
            .image = std::make_shared<const SurfaceImage>(kWidth, kHeight, std::move(texels)), .at_black = 0.5, .at_white = 1.0};
        const MappedSpring spring{.spring_n_per_m = 1e15, .pressed_n = 3.0};
        MapPlace place = map_gradients(triangles[0]);
        double largest_sampled = 0.0;
        for (int along = -100; along <= 100; ++along) {
          Eigen::Vector2d texel(odd_texel % kWidth + 0.5, odd_texel / kWidth + 0.5);
          texel[is_along_columns ? 1 : 0] += 0.01 * along;
          place.texcoord = {texel.x() / kWidth, texel.y() / kHeight};
          const ImageMap::Value at = share.at(place);
          largest_sampled = std::max(largest_sampled, spring.pressed_n / at.number * at.gradient.norm());
        }
        const double found = spring.added_n_per_m(share, triangles, 0.0);
        EXPECT_GE(found, (1.0 - 1e-3) * largest_sampled) << odd_texel << " " << is_along_columns << " " << is_soft;
        EXPECT_LE(found, 1.1 * largest_sampled) << odd_texel << " " << is_along_columns << " " << is_soft;
      }
    }
  }
}

// All texels but one are equal. The stiffest texel counts, wherever it lies.
TEST(MappedSpring, TheStiffestTexelIsFoundWhereverItLies) {
  constexpr int kSize = 4;
  for (int odd_texel = 0; odd_texel < kSize * kSize; ++odd_texel) {
    std::vector<float> texels(kSize * kSize, 0.0F);
    texels[static_cast<std::size_t>(odd_texel)] = 1.0F;
    const ImageMap share{.image = std::make_shared<const SurfaceImage>(kSize, kSize, std::move(texels)), .at_black = 0.5, .at_white = 1.0};
    const MappedSpring spring{.spring_n_per_m = 1000.0, .beside_n_per_m = 300.0, .pressed_n = 1e-9};
    // In the middle of a texel its own share has a weight of 9/16.
    const double expected = (0.5 + 0.5 * 9.0 / 16.0) * 1000.0 + 300.0;
    const double found = spring.largest_n_per_m(share, sheet(1.0, 1.0));
    EXPECT_GE(found, (1.0 - 1e-9) * expected) << odd_texel;
    EXPECT_LE(found, 1.06 * expected) << odd_texel;
  }
  // The spring of friction counts where it is stiffer than the spring of the surface.
  const ImageMap uniform_share{.image = image_of(2, 2, [](double, double) { return 1.0; }), .at_black = 0.5, .at_white = 1.0};
  const MappedSpring with_friction{.spring_n_per_m = 1000.0, .beside_n_per_m = 300.0, .sideways_n_per_m = 5000.0, .pressed_n = 1e-9};
  EXPECT_NEAR(with_friction.largest_n_per_m(uniform_share, sheet(1.0, 1.0)), kMapMargin * 5000.0, 1e-6);
}

// Where one triangle maps the image more densely, its curvature counts.
TEST(MappedSpring, TheDensestTriangleCounts) {
  std::mt19937_64 random(5);
  const ImageMap map{.image = noise(random, 8, 8), .at_black = -0.001, .at_white = 0.0};
  Triangles triangles = sheet(0.1, 0.1);
  const double wide = largest_curvature(map, triangles);
  const Triangles dense = sheet(0.05, 0.05);
  triangles.push_back(dense[0]);
  const double both = largest_curvature(map, triangles);
  EXPECT_NEAR(both, 4.0 * wide, 0.06 * both);
}

// Compared with the formula of K (mapped_spring.h), with the force at each place.
TEST(MappedSpring, NoPlaceIsStifferAndTheStiffestIsFound) {
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const ImageMap share{.image = noise(random, 1 + static_cast<int>(random() % 8), 1 + static_cast<int>(random() % 8)),
                         .at_black = std::pow(10.0, -2.0 * unit(random)),
                         .at_white = 1.0};
    const double scale = std::pow(10.0, 2.0 * unit(random) - 3.0);
    const Triangles triangles = sheet(scale, scale * (0.3 + 3.0 * unit(random)), 0.3 * scale);
    const MappedSpring spring{.spring_n_per_m = 200.0 + 2000.0 * unit(random), .pressed_n = 10.0 * unit(random)};
    MapPlace place = map_gradients(triangles[0]);
    double largest_sampled = 0.0;
    for (int n = 0; n < 30000; ++n) {
      place.texcoord = {unit(random), unit(random)};
      const ImageMap::Value at = share.at(place);
      const double force = spring.pressed_n / at.number;
      Mat3 k = Mat3::Zero();
      k(2, 2) = at.number * spring.spring_n_per_m;
      k.topLeftCorner<2, 2>() = 0.5 * force * force / spring.spring_n_per_m * second_derivative(share, place, 1e-6 * scale);
      k.col(2).head<2>() = k.row(2).head<2>() = -force * at.gradient.head<2>();
      largest_sampled = std::max(largest_sampled, Eigen::SelfAdjointEigenSolver<Mat3>(k, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff());
    }
    const double found = spring.largest_n_per_m(share, triangles);
    EXPECT_GE(found, (1.0 - 1e-3) * largest_sampled) << "seed " << seed;
    EXPECT_LE(found, 1.6 * largest_sampled) << "seed " << seed;
    EXPECT_GE(spring.added_n_per_m(share, triangles, 0.5), spring.added_n_per_m(share, triangles, 0.0)) << "seed " << seed;
  }
}

// The spring is so stiff that only the gradient of the share counts. Compared with its formula at places all over strongly sheared sheets.
TEST(MappedSpring, AddedStiffnessOnBumpsIsThatOfTheSteepestPlace) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const ImageMap share{
        .image = noise(random, 2 + static_cast<int>(random() % 6), 2 + static_cast<int>(random() % 6)), .at_black = 0.2, .at_white = 1.0};
    const double slope = unit(random);
    const Triangles triangles = sheet(0.1, 0.1 * (0.3 + unit(random)), 0.2 * (2.0 * unit(random) - 1.0));
    const MappedSpring spring{.spring_n_per_m = 1e15, .pressed_n = 3.0};
    MapPlace place = map_gradients(triangles[0]);
    double largest_sampled = 0.0;
    for (int n = 0; n < 30000; ++n) {
      place.texcoord = {unit(random), unit(random)};
      const ImageMap::Value at = share.at(place);
      largest_sampled =
          std::max(largest_sampled, spring.pressed_n / at.number * at.gradient.norm() * (std::sqrt(1.0 + slope * slope) + slope));
    }
    const double found = spring.added_n_per_m(share, triangles, slope);
    EXPECT_GE(found, (1.0 - 1e-3) * largest_sampled) << "seed " << seed;
    EXPECT_LE(found, 1.1 * largest_sampled) << "seed " << seed;
  }
}

}  // namespace
}  // namespace hapton
