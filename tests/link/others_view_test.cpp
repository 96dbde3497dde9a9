#include "link/others_view.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

ViewTransform view_at(std::uint32_t revision, float x_m) { return {revision, {1, 0, 0, x_m, 0, 1, 0, 0, 0, 0, 1, 0}}; }

TEST(OthersView, IsTheNewestOfAnotherNode) {
  OthersView others;
  const ViewTransform own = view_at(3, 0.1F);
  EXPECT_EQ(others.revision(), 0U);
  others.take(own, Arrival::newest, own);
  EXPECT_EQ(others.revision(), 0U) << "its own, which the hub repeats";
  others.take(view_at(8, 0.2F), Arrival::newest, own);
  others.take(ProbeState{.view_revision = 9}, Arrival::newest, own);
  EXPECT_EQ(others.revision(), 8U);
}

TEST(OthersView, AnOvertakenOneDoesNotComeBack) {
  OthersView others;
  const ViewTransform own = view_at(3, 0.1F);
  others.take(view_at(8, 0.2F), Arrival::newest, own);
  others.take(view_at(7, 0.3F), Arrival::reordered, own);
  EXPECT_EQ(others.revision(), 8U);
  others.take(view_at(2, 0.3F), Arrival::newest, own);
  EXPECT_EQ(others.revision(), 2U) << "another node may set a lower revision";
  others.forget();
  EXPECT_EQ(others.revision(), 0U);
}

}  // namespace
}  // namespace hapton
