#include "scene/rotation_reader.h"

#include <gtest/gtest.h>

#include <string>

namespace hapton {
namespace {

// Reads the rotation of a TOML table into q. Returns the error, or an empty text.
std::string read_rotation_text(const std::string& text, Quat& q) {
  const toml::parse_result parsed = toml::parse(text);
  EXPECT_TRUE(parsed);
  TableReader reader(parsed.table(), "the table");
  read_rotation(parsed.table(), reader, q);
  return reader.error() ? reader.error()->what : "";
}

TEST(RotationReader, TurnsAboutFixedAxesInOrder) {
  Quat q = Quat::Identity();
  EXPECT_EQ(read_rotation_text("rotation_deg = [90, 0, 90]", q), "");
  EXPECT_LT((q * Vec3::UnitY() - Vec3::UnitZ()).norm(), 1e-15) << "about x first, then z leaves it";
  EXPECT_LT((q * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15);
}

TEST(RotationReader, TakesAQuaternionAndMakesItsLengthOne) {
  Quat q = Quat::Identity();
  EXPECT_EQ(read_rotation_text("rotation = [0.6, 0, 0.8001, 0]", q), "");
  EXPECT_NEAR(q.norm(), 1.0, 1e-15);
  EXPECT_NEAR(q.y() / q.w(), 0.8001 / 0.6, 1e-12);
}

TEST(RotationReader, KeepsTheRotationIfTheTableHasNoKeyForIt) {
  Quat q(0.6, 0.0, 0.8, 0.0);
  EXPECT_EQ(read_rotation_text("other = 1", q), "");
  EXPECT_EQ(q.coeffs(), Quat(0.6, 0.0, 0.8, 0.0).coeffs());
}

TEST(RotationReader, RejectsTwoKeysAndInvalidRotations) {
  Quat q = Quat::Identity();
  EXPECT_NE(read_rotation_text("rotation = [1, 0, 0, 0]\nrotation_deg = [0, 0, 0]", q).find("keep one"), std::string::npos);
  EXPECT_NE(read_rotation_text("rotation = [1, 1, 0, 0]", q).find("length 1"), std::string::npos);
  EXPECT_NE(read_rotation_text("rotation_deg = [361, 0, 0]", q).find("at most 360"), std::string::npos);
}

}  // namespace
}  // namespace hapton
