#include <embree3/rtcore.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <string>

#include "bench/measure/triangle_tests.h"
#include "bench/peers/peer_structures.h"

namespace hapton {
namespace {

using Vec3f = Eigen::Vector3f;

// first_hit(): rtcIntersect1 along the segment, tfar 1. nearest(): rtcPointQuery. Robust mode: watertight edges, as touch needs.
class Embree final : public QueryStructure {
 public:
  Embree(const TriangleMesh& mesh, int threads) {
    device_ = rtcNewDevice(threads == 0 ? "" : ("threads=" + std::to_string(threads)).c_str());
    rtcSetDeviceMemoryMonitorFunction(device_, &count_bytes, &bytes_);
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    vertices_ = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices.size()));
    triangles_ = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), mesh.triangles.size()));
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      for (int k = 0; k < 3; ++k) vertices_[3 * i + static_cast<std::size_t>(k)] = static_cast<float>(mesh.vertices[i][k]);
    }
    std::memcpy(triangles_, mesh.triangles.data(), mesh.triangles.size() * sizeof(Triangle));
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
    rtcInitIntersectContext(&ray_context_);
    rtcInitPointQueryContext(&point_context_);
  }
  ~Embree() override {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  Embree(const Embree&) = delete;
  Embree& operator=(const Embree&) = delete;

  double first_hit(const Vec3& from, const Vec3& to) override {
    const Vec3 segment = to - from;
    RTCRayHit query = {};
    query.ray.org_x = static_cast<float>(from.x());
    query.ray.org_y = static_cast<float>(from.y());
    query.ray.org_z = static_cast<float>(from.z());
    query.ray.dir_x = static_cast<float>(segment.x());
    query.ray.dir_y = static_cast<float>(segment.y());
    query.ray.dir_z = static_cast<float>(segment.z());
    query.ray.tfar = 1.0F;
    query.ray.mask = 0xFFFFFFFFU;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &ray_context_, &query);
    return query.hit.geomID == RTC_INVALID_GEOMETRY_ID ? kNothingFound : static_cast<double>(query.ray.tfar);
  }

  double nearest(const Vec3& p, double radius) override {
    RTCPointQuery query = {};
    query.x = static_cast<float>(p.x());
    query.y = static_cast<float>(p.y());
    query.z = static_cast<float>(p.z());
    query.radius = static_cast<float>(radius);
    found_ = kNothingFound;
    rtcPointQuery(scene_, &query, &point_context_, &test_triangle, this);
    return found_;
  }

  std::size_t bytes() const override { return static_cast<std::size_t>(std::max<std::int64_t>(0, bytes_.load())); }

 private:
  static bool count_bytes(void* sum, ssize_t bytes, bool) {
    *static_cast<std::atomic<std::int64_t>*>(sum) += bytes;
    return true;
  }
  static bool test_triangle(RTCPointQueryFunctionArguments* arguments) {
    auto& self = *static_cast<Embree*>(arguments->userPtr);
    const std::uint32_t* t = self.triangles_ + 3 * static_cast<std::size_t>(arguments->primID);
    const auto corner = [&](std::uint32_t index) {
      return Vec3f(Eigen::Map<const Vec3f>(self.vertices_ + 3 * static_cast<std::size_t>(index)));
    };
    const Vec3f p(arguments->query->x, arguments->query->y, arguments->query->z);
    const float d = std::sqrt(point_distance_squared<float>(p, corner(t[0]), corner(t[1]), corner(t[2])));
    if (!(d <= arguments->query->radius)) return false;
    arguments->query->radius = d;
    self.found_ = static_cast<double>(d);
    return true;
  }

  std::atomic<std::int64_t> bytes_ = 0;
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  float* vertices_ = nullptr;
  std::uint32_t* triangles_ = nullptr;
  RTCIntersectContext ray_context_;
  RTCPointQueryContext point_context_;
  double found_ = kNothingFound;
};

}  // namespace

std::vector<QueryStructureKind> embree_structures() {
  const std::string note = "Embree 3 rtcIntersect1 / rtcPointQuery, robust; built with ";
  const auto make = [](int threads) {
    return
        [threads](const TriangleMesh& mesh) -> Result<std::unique_ptr<QueryStructure>> { return std::make_unique<Embree>(mesh, threads); };
  };
  return {{.library = {}, .name = "embree", .precision = "float", .note = note + "one thread", .make = make(1)},
          {.library = {}, .name = "embree all threads", .precision = "float", .note = note + "every CPU's thread", .make = make(0)}};
}

}  // namespace hapton
