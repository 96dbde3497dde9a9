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
inline void expect_settled(TriangleMesh shape, const Vec3& p_SD, const MethodOutput& output, bool settles) {
  if (compute_winding_number(shape, p_SD) > 1.0 - 1e-6) {
    ASSERT_TRUE(output.contact) << "the hand is within the body";
  }
  if (!output.contact) return;
  ASSERT_NEAR(compute_winding_number(shape, output.p_SP + 1e-9 * output.force_n.normalized()), 0.0, 0.02);
  if (!settles) return;
  TouchScene still;
  still.objects.push_back({.mesh = made::shared(std::move(shape)), .material = {}});
  auto reference = ReferenceMethod::make_reference({}, still);
  ASSERT_TRUE(reference);
  const MethodOutput settled = (*reference)->settle_from(output.p_SP + 1e-10 * output.force_n.normalized(), p_SD);
  ASSERT_LT((settled.p_SP - output.p_SP).norm(), 1e-7);
  ASSERT_LT((settled.force_n - output.force_n).norm(), 1e-3 * (0.1 + output.force_n.norm()));
}

}  // namespace hapton
