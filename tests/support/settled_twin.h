#pragma once

#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include "core/force/reference/reference_method.h"
#include "core/geometry/winding_number.h"
#include "tests/support/made_meshes.h"

namespace hapton {

// Checks a step on a surface that changes its shape against a brute-force twin: all triangles of the mesh at that time. A hand inside the
// body must be in contact and the proxy outside; if `settles`, the reference, started at the proxy, must stay there.
inline void expect_settled(TriangleMesh shape, const Vec3& p_SD, const MethodOutput& felt, bool settles) {
  if (compute_winding_number(shape, p_SD) > 1.0 - 1e-6) {
    ASSERT_TRUE(felt.contact) << "the hand is within the body";
  }
  if (!felt.contact) return;
  ASSERT_NEAR(compute_winding_number(shape, felt.p_SP + 1e-9 * felt.force_n.normalized()), 0.0, 0.02);
  if (!settles) return;
  TouchScene still;
  still.objects.push_back({.mesh = made::shared(std::move(shape)), .material = {}});
  auto reference = ReferenceMethod::make_reference({}, still);
  ASSERT_TRUE(reference);
  const MethodOutput settled = (*reference)->settle_from(felt.p_SP + 1e-10 * felt.force_n.normalized(), p_SD);
  ASSERT_LT((settled.p_SP - felt.p_SP).norm(), 1e-7);
  ASSERT_LT((settled.force_n - felt.force_n).norm(), 1e-3 * (0.1 + felt.force_n.norm()));
}

}  // namespace hapton
