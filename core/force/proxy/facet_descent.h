#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/collision/neighbourhood.h"

namespace hapton {

// How a point that a surface holds gets to the nearest constrained minimum of its distance to the device, worked out from the facets alone:
// straight over faces, along folds, round corners, always downhill, where the surface is plain: every edge on the way has two faces, every
// corner one closed fan of them, and no face leans by more than 60 degrees from the first. Then the minimum needs no sweep, only the
// assurance that nothing else comes near the way (Neighbourhood::is_clear). Whatever is not plain, rests at corners among it, is left to
// others.
//
// Frame: the neighbourhood's local one. RT: yes.
class FacetDescent {
 public:
  // A face that holds the point.
  struct Hold {
    std::uint32_t place = Neighbourhood::kNowhere;
    Vec3 normal = Vec3::Zero();  // unit, towards the point
    double push = 0.0;           // point - device = sum of push * normal, but for friction
  };

  // Coulomb friction of the surface. The point stays where the way to the foot of the device is no longer than `at_rest` times the push;
  // once it slides it stops `sliding` times the push short of it.
  struct Friction {
    double at_rest = 0.0;
    double sliding = 0.0;
    bool slides = false;  // as the last step left it
  };

  // `rest`: how far the point stays off the surface, far below `margin`, the distance within which an edge or corner has a say.
  FacetDescent(Neighbourhood& near, double rest, double margin) : near_(near), rest_(rest), margin_(margin) {}
  FacetDescent(Neighbourhood& near, double rest, double margin, const Friction& friction)
      : near_(near), rest_(rest), margin_(margin), friction_(friction), rubs_(true), slides_(friction.slides) {}

  // From `start`, held by one face or by the two faces of a fold: pushes need not be set. False where the way is not plain, or leaves what
  // the neighbourhood covers.
  bool run(const Vec3& start, std::span<const Hold> held, const Vec3& device) noexcept;

  // After a run that succeeded.
  bool met_fold() const { return met_fold_; }  // a fold or corner had a say
  bool slides() const { return slides_; }      // friction did not hold it
  const Vec3& end() const { return end_; }
  std::span<const Hold> holds() const { return {holds_.data(), static_cast<std::size_t>(hold_count_)}; }
  std::span<const std::uint32_t> faces() const {
    return {faces_.data(), static_cast<std::size_t>(face_count_)};
  }  // places, those touched on the way

 private:
  static constexpr int kMaxPoints = 24;
  static constexpr int kMaxFaces = 64;
  static constexpr int kMaxFan = 16;

  enum class Next : std::uint8_t { face, edge, corner, done, unclear };
  // A face with the side the point is on.
  struct Facet {
    std::uint32_t place;
    double side;  // of its winding
    const ContactTriangle* shape;
  };
  // Where the point stands. On a face: `edge` is the one it came in by, `corner` the one it came from, or -1. On an edge: number `edge` of
  // `facet`, with `other` beyond it. At a corner: number `corner` of `facet`.
  struct Stand {
    const Facet* facet = nullptr;
    const Facet* other = nullptr;
    int edge = -1;
    int corner = -1;
    int other_edge = -1;
  };
  using Fan = std::array<const Facet*, kMaxFan>;

  bool begin(const Vec3& start, std::span<const Hold> held);
  Next cross_face(const Vec3& device);
  Next follow_edge(const Vec3& device);
  Next turn_corner(const Vec3& device);
  bool collect_fan(Fan& fan, std::array<int, kMaxFan>& corners, int& count);
  bool winds_once(std::span<const Facet* const> fan, std::span<const int> corners);
  const Facet* find_other(const Facet& facet, int edge, int& other_edge);
  bool stand_on_edge(int edge);
  void stand_on_face(const Facet* facet, int edge, int corner);
  bool is_clear(std::span<const Vec3> points) const;
  bool go_to(const Vec3& p);
  const Facet* add_facet(std::uint32_t place, double side);
  static const ContactTriangle& shape(const Facet* facet) { return *facet->shape; }
  static Vec3 normal_of(const Facet* facet) { return facet->side * facet->shape->normal(); }
  static Vec3 foot_on(const Facet* facet, const Vec3& device);
  bool rub(const Vec3& device, const Vec3& foot, Vec3& goal);
  Next rest_on_face(const Vec3& device, const Vec3& goal);
  Next rest_in_fold(const Vec3& device, const Vec3& on_edge);

  Neighbourhood& near_;
  double rest_;
  double margin_;
  Stand at_;
  Vec3 first_normal_ = Vec3::Zero();
  std::array<Vec3, kMaxPoints> points_;
  int point_count_ = 0;
  std::array<Facet, kMaxFaces> facets_;         // those touched,
  std::array<std::uint32_t, kMaxFaces> faces_;  // their places
  int face_count_ = 0;
  Vec3 end_ = Vec3::Zero();
  std::array<Hold, 2> holds_;
  int hold_count_ = 0;
  bool met_fold_ = false;
  Friction friction_;
  bool rubs_ = false;
  bool slides_ = false;
};

}  // namespace hapton
