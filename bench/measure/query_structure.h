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

// A structure over a mesh's triangles with the two queries of a force method, made by Hapton or by another library. Frame and units: the
// mesh's. RT: no. Threads: one.
class QueryStructure {
 public:
  virtual ~QueryStructure() = default;

  // Position at which the segment first meets a triangle, as a share of its length, 0..1; kNothingFound if there is none.
  virtual double first_hit(const Vec3& from, const Vec3& to) = 0;

  // The distance from p to the nearest triangle if that is at most `radius`; otherwise kNothingFound.
  virtual double nearest(const Vec3& p, double radius) = 0;

  // Memory of the structure, if the library reports it; 0: it does not, and the benchmark takes the growth of the heap.
  virtual std::size_t bytes() const { return 0; }
};

// A kind of structure to measure: its name, what it can do, and how to make one.
struct QueryStructureKind {
  std::string library = {};    // "hapton", "embree" ...
  std::string name = {};       // "fdh", "grid" ...
  int parameter = 0;           // directions, cells along an axis, threads ...; 0: none
  std::string precision = {};  // precision of its triangle tests: "float", "double"
  bool segments = true;        // true: it has first_hit()
  bool nearests = true;        // true: it has nearest()
  std::string note = {};       // printed with its results
  std::function<Result<std::unique_ptr<QueryStructure>>(const TriangleMesh&)> make = {};  // the mesh outlives the structure

  // For example "fdh 14", "brute".
  std::string full_name() const { return parameter == 0 ? name : name + " " + std::to_string(parameter); }
};

}  // namespace hapton
