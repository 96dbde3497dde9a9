#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/tool/local_contacts.h"

namespace hapton {

// What a contact exerts on the tool: force, and torque about the grip point; local units, divided by the coupling's linear stiffness.
struct ContactForce {
  int index = -1;  // of the contact in LocalContacts
  Vec6 wrench = Vec6::Zero();
  double normal = 0.0;  // the part of the force along the contact's normal
};

// The forces of contacts on a rigid tool under Coulomb friction, and the pose at which they hold the tool.
//
// Each contact exerts a normal force that is not negative, and a tangential force of at most the coefficient times the normal force,
// against the slip of its point since the tool was at `slip_start`. Nonlinear Gauss-Seidel iteration (Jourdan, Alart & Jean 1998): corrects
// the forces of one contact after another while those of the others stay, until the corrections are negligible. Even if kMaxRounds end it
// first, the coupling balances exactly the sum of these forces: friction stays within its coefficient, and no contact attracts.
//
// Frame: local units; forces are divided by the coupling's linear stiffness. RT: yes. Threads: one.
class ContactCones {
 public:
  static constexpr std::size_t kMax = 12;     // contacts; 3 to 6 carry a tool
  static constexpr int kMaxRounds = 120;      // of the iteration in a step; the next step continues from its forces
  static constexpr std::size_t kMaxSets = 6;  // runs of the iteration; after each, the contact violated most is added

  // Finds where the contacts hold the tool while the device is at `wanted`. wanted, slip_start: motions from local.proxy. frictionless:
  // result of local.solve(); its contacts and those that pushed in the last step are considered first. The iteration starts from the forces
  // of the last step. is_static: static friction coefficients, otherwise dynamic ones.
  void solve(const LocalContacts& local, const Vec6& wanted, const Vec6& slip_start, const LocalContacts::Solution& frictionless,
             bool is_static) noexcept;
  // The next step does not start from the forces of the last one.
  void forget() noexcept { count_ = previous_count_ = 0; }

  // Results of the last step:
  const Vec6& motion() const noexcept { return motion_; }  // from local.proxy; may violate bounds by what the limits above left
  double slip() const noexcept { return slip_; }  // largest since `slip_start`, of contacts with at least 2^-10 of the largest force
  bool holds() const noexcept { return previous_count_ > 0; }  // a contact pushes
  // Writes the forces of the contacts that push; returns their number. Their sum is what the coupling exerts at motion(). local: as in
  // solve().
  std::size_t list_forces(const LocalContacts& local, std::span<ContactForce, kMax> forces) const noexcept;
  int rounds() const noexcept { return rounds_; }

 private:
  // Rows are scaled by the root of the inverse stiffness, so that a force times its row is the scaled displacement that it causes.
  struct Contact {
    int index = -1;  // in LocalContacts
    Vec6 normal_row = Vec6::Zero();
    std::array<Vec6, 2> tangent_rows = {};
    std::array<Vec3, 2> tangents = {};
    std::array<double, 2> slip_start = {};  // displacement of its point along the tangents at `slip_start`
    double least = 0.0;                     // as MotionBound::least
    double coefficient = 0.0;
    double normal_compliance = 1.0;
    double tangent_compliance = 1.0;        // an upper bound of that in any tangential direction
    double normal = 0.0;                    // force
    std::array<double, 2> tangential = {};  // force along the tangents
  };
  struct PreviousContact {  // a contact of the last step, and its force
    Vec3 arm = Vec3::Zero();
    Vec3 direction = Vec3::Zero();
    double normal = 0.0;
    Vec3 tangential = Vec3::Zero();
  };

  bool has(int index) const noexcept;
  void add(const LocalContacts& local, const Vec6& slip_start, bool is_static, int index, double normal, const Vec3& tangential) noexcept;
  void add_previous(const LocalContacts& local, const Vec6& slip_start, bool is_static) noexcept;
  bool add_violated(const LocalContacts& local, const Vec6& slip_start, bool is_static) noexcept;
  double correct(Contact& contact) noexcept;
  void iterate(const Vec6& goal) noexcept;
  void store_results(const LocalContacts& local) noexcept;

  std::array<Contact, kMax> contacts_ = {};
  std::size_t count_ = 0;
  std::array<PreviousContact, kMax> previous_ = {};  // those that pushed in the last step
  std::size_t previous_count_ = 0;
  Vec6 scaled_motion_ = Vec6::Zero();  // scaled: the device's motion plus the displacements by all forces
  Vec6 motion_ = Vec6::Zero();
  double slip_ = 0.0;
  int rounds_ = 0;
};

}  // namespace hapton
