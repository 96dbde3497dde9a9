#pragma once

#include <array>
#include <cstddef>

#include "core/tool/local_contacts.h"

namespace hapton {

// The forces of contacts on a rigid tool under Coulomb friction, and where they hold it.
//
// Each contact exerts a normal force that is not negative, and a tangential one of at most the coefficient times that, against the slip of
// its point since the tool was at `from`. Nonlinear Gauss-Seidel iteration (Jourdan, Alart & Jean 1998): the forces of one contact after
// the other are corrected while those of the others stay, until no correction matters. However much of that is left after kMaxRounds, the
// coupling holds against exactly the sum of these forces: friction is never more than the coefficient allows, and no contact attracts.
//
// Frame: local units; forces over the coupling's linear stiffness. RT: yes. Threads: one.
class ContactCones {
 public:
  static constexpr std::size_t kMax = 12;     // contacts; 3 to 6 carry a tool
  static constexpr int kMaxRounds = 120;      // of the iteration in a step; what is left goes on in the next one
  static constexpr std::size_t kMaxSets = 6;  // a contact that was left out and is violated is added, and the iteration goes on

  // Where the contacts hold the tool while the device is at `wanted`. wanted, from: motions from local.proxy. frictionless: of
  // local.solve(); its contacts and those that pushed in the last step are considered first. The forces of the last step are the first
  // guess.
  void solve(const LocalContacts& local, const Vec6& wanted, const Vec6& from, const LocalContacts::Solution& frictionless,
             bool is_static) noexcept;
  // The last step is not a guess for the next one.
  void forget() noexcept { known_count_ = 0; }

  // Of the last step:
  const Vec6& motion() const noexcept { return motion_; }   // from local.proxy; violates a bound by what the iteration left
  double slip() const noexcept { return slip_; }            // since `from`, the largest of a contact that pushes
  bool holds() const noexcept { return known_count_ > 0; }  // a contact pushes
  int rounds() const noexcept { return rounds_; }

 private:
  // Rows are scaled by the root of the inverse stiffness, so that a force times its row is the displacement that it causes.
  struct Contact {
    int index = -1;  // of LocalContacts
    Vec6 normal_row = Vec6::Zero();
    std::array<Vec6, 2> tangent_rows = {};
    std::array<Vec3, 2> tangents = {};
    std::array<double, 2> from = {};  // along the tangents, where its point was
    double least = 0.0;
    double coefficient = 0.0;
    double normal_compliance = 1.0;
    double tangent_compliance = 1.0;  // at least that of any tangential direction
    double normal = 0.0;
    std::array<double, 2> tangential = {};
  };
  struct Known {
    Vec3 arm = Vec3::Zero();
    Vec3 direction = Vec3::Zero();
    double normal = 0.0;
    Vec3 tangential = Vec3::Zero();
  };

  bool has(int index) const noexcept;
  void add(const LocalContacts& local, const Vec6& from, bool is_static, int index, double normal, const Vec3& tangential) noexcept;
  void add_known(const LocalContacts& local, const Vec6& from, bool is_static) noexcept;
  bool add_violated(const LocalContacts& local, const Vec6& from, bool is_static) noexcept;
  double correct(Contact& contact) noexcept;
  void iterate(const Vec6& goal) noexcept;
  void note(const LocalContacts& local) noexcept;

  std::array<Contact, kMax> contacts_ = {};
  std::size_t count_ = 0;
  std::array<Known, kMax> known_ = {};  // those that pushed in the last step
  std::size_t known_count_ = 0;
  Vec6 at_ = Vec6::Zero();  // scaled: the device's motion, and what all forces cause
  Vec6 motion_ = Vec6::Zero();
  double slip_ = 0.0;
  int rounds_ = 0;
};

}  // namespace hapton
