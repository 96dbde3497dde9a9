#include <gtest/gtest.h>

#include "core/force/force_method.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TEST(MakeMethod, BuildsTheSweep) {
  const auto method = make_method({.name = "sweep"}, {.objects = {{made::shared(made::sphere(0.1, 8)), {}}}});
  ASSERT_TRUE(method);
  EXPECT_NE((*method)->describe().find("sweep"), std::string::npos);
}

TEST(MakeMethod, AnUnknownNameIsToldTheKnownOnes) {
  const auto method = make_method({.name = "sweeep"}, {.objects = {{made::shared(made::sphere(0.1, 8)), {}}}});
  ASSERT_FALSE(method);
  EXPECT_NE(method.error().what.find("'sweeep'"), std::string::npos);
  EXPECT_NE(method.error().what.find("choose one of: "), std::string::npos);
  EXPECT_NE(method.error().what.find("sweep"), std::string::npos);
}

TEST(MakeMethod, EmptySceneIsRefused) {
  EXPECT_FALSE(make_method({}, {}));
  EXPECT_FALSE(make_method({}, {.objects = {{nullptr, {}}}}));
}

}  // namespace
}  // namespace hapton
