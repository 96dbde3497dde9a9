#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

constexpr double kNothingFound = std::numeric_limits<double>::infinity();

// A structure over a mesh's triangles with the two queries of a force method. Frame and units: the mesh's. RT: as the library behind
// it.
class QueryStructure {
 public:
  virtual ~QueryStructure() = default;

  // Where the segment first meets a triangle, as a share of its length, 0..1; kNothingFound if there is none.
  virtual double first_hit(const Vec3& from, const Vec3& to) = 0;

  // The distance from p to the nearest triangle, where one is at most `radius` away; else kNothingFound.
  virtual double nearest(const Vec3& p, double radius) = 0;

  // The library's own size, if it reports one; otherwise 0, and the heap's growth is used.
  virtual std::size_t bytes() const { return 0; }
};

// A structure by name.
struct QueryStructureKind {
  std::string library = {};    // "hapton", "embree" ...
  std::string name = {};       // "fdh", "grid" ...
  int parameter = 0;           // directions, cells along an axis, threads ...; 0: none
  std::string precision = {};  // of triangle tests: "float", "double"
  bool segments = true;
  bool nearests = true;
  std::string note = {};                                                                  // note for readers of its results
  std::function<Result<std::unique_ptr<QueryStructure>>(const TriangleMesh&)> make = {};  // the mesh outlives the structure

  // "fdh 14", "brute"
  std::string full_name() const { return parameter == 0 ? name : name + " " + std::to_string(parameter); }
};

}  // namespace hapton
