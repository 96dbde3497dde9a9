#include "remote_touch/packet_size.h"

#include <gtest/gtest.h>

#include "link/endpoint.h"
#include "link/seal_format.h"

namespace hapton {
namespace {

constexpr std::size_t kIpAndUdpBytes = 28;

TEST(PacketSize, IsThatOfASealedDatagramInAnIpPacket) {
  EXPECT_GT(packet_bytes_of_state(), kIpAndUdpBytes + seal::kOverheadBytes + 7 * sizeof(double)) << "position and orientation";
  EXPECT_GT(packet_bytes_of_force(), kIpAndUdpBytes + seal::kOverheadBytes + 12 * sizeof(double)) << "force, torque, offset and turn";
  EXPECT_LT(packet_bytes_of_state(), 260U);
  EXPECT_LT(packet_bytes_of_force(), 310U);
}

TEST(PacketSize, ATileFitsADatagram) {
  PatchTile tile;
  tile.vertex_count = PatchTile::kMaxVertices;
  tile.triangle_count = PatchTile::kMaxTriangles;
  tile.vertices.fill(0xff);
  EXPECT_GT(packet_bytes_of(tile), PatchTile::kMaxVertices * PatchTile::kVertexBytes);
  EXPECT_LE(packet_bytes_of(tile), kMaxDatagramBytes + kIpAndUdpBytes);
}

}  // namespace
}  // namespace hapton
