#include "tools/dynamics/dynamics_world.h"

#include "core/geometry/convex_pieces.h"
#include "core/geometry/mass_properties.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/simplify_small.h"
#include "core/math/cross_matrix.h"
#include "scene/object_motion.h"

#ifdef HAPTON_WITH_BULLET
#include <BulletCollision/CollisionDispatch/btInternalEdgeUtility.h>
#include <LinearMath/btConvexHullComputer.h>
#include <btBulletDynamicsCommon.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>
#endif

namespace hapton::dynamics {

#ifndef HAPTON_WITH_BULLET

struct DynamicsWorld::Parts {};

Result<std::unique_ptr<DynamicsWorld>> DynamicsWorld::make(const Scene&, double) {
  return fail("this program was built without Bullet; install libbullet-dev and build again");
}
DynamicsWorld::DynamicsWorld(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
DynamicsWorld::~DynamicsWorld() = default;
std::span<const int> DynamicsWorld::bodies() const noexcept { return {}; }
bool DynamicsWorld::is_body(int) const noexcept { return false; }
void DynamicsWorld::set_gravity(const Vec3&) {}
void DynamicsWorld::press(const std::optional<Push>&) {}
void DynamicsWorld::move_obstacle(int, const Pose&) {}
void DynamicsWorld::pick_up_obstacle(int) {}
void DynamicsWorld::put_down_obstacle(int, const Pose&) {}
void DynamicsWorld::step() {}
Keyframe DynamicsWorld::place(int, double) const { return {}; }
std::span<const int> DynamicsWorld::fallen() const noexcept { return {}; }

#else

// One object of the scene. Frames: S scene, B body (see BodyFrame), O the object as the scene file places it.
struct Member {
  std::unique_ptr<btTriangleMesh> triangles;               // set only for an obstacle
  std::unique_ptr<btTriangleInfoMap> edges;                // set only for an obstacle
  std::vector<std::unique_ptr<btConvexHullShape>> pieces;  // set only for a body that is not convex
  std::unique_ptr<btCollisionShape> shape;
  std::unique_ptr<btRigidBody> body;
  Pose X_SB = Pose::Identity();  // where the scene file places it
  bool has_mass = false;
  Vec3 pivot_S = Vec3::Zero();
  double radius_m = 0.0;  // of a body: no point of it is farther from the pivot than this
};

namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

// Bullet computes in centimetres here, because its absolute tolerances suit bodies of 0.05 to 10 units.
constexpr double kUnitsPerM = 100.0;
// Collision margin of each shape: two surfaces stay 0.1 mm apart, which is not visible. Bullet finds contacts within the margins.
constexpr double kMarginM = 5e-5;
// Iterations of the contact solver: with Bullet's default of 10, stacks of a few bodies creep.
constexpr int kSolverIterations = 30;
// Bodies that are slower than this for two seconds (Bullet's gDeactivationTime) come to rest.
constexpr double kSleepMPerS = 1e-3;
constexpr double kSleepRadPerS = 0.05;
// A body farther than this from the centre of the scene, in diagonals of the scene, has fallen out of it.
constexpr double kFallenDiagonals = 2.0;

btVector3 to_bullet(const Vec3& v) { return {btScalar(v.x()), btScalar(v.y()), btScalar(v.z())}; }
Vec3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
btVector3 to_units(const Vec3& v_m) { return to_bullet(kUnitsPerM * v_m); }

btTransform to_bullet(const Pose& X) {
  const Quat q(X.linear());
  return btTransform(btQuaternion(btScalar(q.x()), btScalar(q.y()), btScalar(q.z()), btScalar(q.w())), to_units(X.translation()));
}

Pose from_bullet(const btTransform& X) {
  const btQuaternion q = X.getRotation();
  Pose pose = Pose::Identity();
  pose.translation() = from_bullet(X.getOrigin()) / kUnitsPerM;
  pose.linear() = Quat(q.w(), q.x(), q.y(), q.z()).normalized().toRotationMatrix();
  return pose;
}

// Largest number of convex pieces of a body: more cost time without a visible difference.
constexpr std::size_t kMaxPieces = 64;

// The frame B of a body: its origin is the centre of mass, its axes are the principal axes. X_SB: where the scene file places it.
struct BodyFrame {
  Pose X_SB = Pose::Identity();
  Vec3 inertia_per_mass = Vec3::Zero();
};

BodyFrame find_frame(const MassProperties& properties) {
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(properties.inertia_per_mass);
  BodyFrame frame;
  frame.inertia_per_mass = axes.eigenvalues();
  frame.X_SB.translation() = properties.centre;
  frame.X_SB.linear() = axes.eigenvectors();
  if (frame.X_SB.linear().determinant() < 0.0) frame.X_SB.linear().col(0) *= -1.0;
  return frame;
}

std::unique_ptr<btTriangleMesh> make_triangles(const TriangleMesh& mesh) {
  auto triangles = std::make_unique<btTriangleMesh>(true, false);
  triangles->preallocateVertices(static_cast<int>(mesh.vertices.size()));
  triangles->preallocateIndices(static_cast<int>(3 * mesh.triangles.size()));
  for (const Vec3& vertex : mesh.vertices) triangles->findOrAddVertex(to_units(vertex), false);
  for (const auto& triangle : mesh.triangles) {
    triangles->addTriangleIndices(static_cast<int>(triangle[0]), static_cast<int>(triangle[1]), static_cast<int>(triangle[2]));
  }
  return triangles;
}

// The convex hull of points given in frame S, as a shape in frame B that has only the corners of the hull.
std::unique_ptr<btConvexHullShape> make_hull(const std::vector<Vec3>& points, const Pose& X_BS) {
  btConvexHullComputer computer;
  computer.compute(points.front().data(), sizeof(Vec3), static_cast<int>(points.size()), 0, 0);
  auto shape = std::make_unique<btConvexHullShape>();
  for (int i = 0; i < computer.vertices.size(); ++i) shape->addPoint(to_units(X_BS * from_bullet(computer.vertices[i])), false);
  shape->recalcLocalAabb();
  shape->setMargin(btScalar(kMarginM * kUnitsPerM));
  return shape;
}

// Bullet's callback for a new contact. A contact with the edge between two triangles of a flat surface gets the normal of the surface, so
// that a body slides over the edge.
bool smooth_edge(btManifoldPoint& point, const btCollisionObjectWrapper* a, int part_a, int index_a, const btCollisionObjectWrapper* b,
                 int part_b, int index_b) {
  btAdjustInternalEdgeContacts(point, b, a, part_b, index_b);
  btAdjustInternalEdgeContacts(point, a, b, part_a, index_a);
  return true;
}

Member make_obstacle(const SceneObject& object) {
  Member member;
  member.triangles = make_triangles(*object.mesh);
  auto shape = std::make_unique<btBvhTriangleMeshShape>(member.triangles.get(), true);
  member.edges = std::make_unique<btTriangleInfoMap>();
  btGenerateInternalEdgeInfo(shape.get(), member.edges.get());
  member.shape = std::move(shape);
  member.shape->setMargin(btScalar(kMarginM * kUnitsPerM));
  member.body = std::make_unique<btRigidBody>(0, nullptr, member.shape.get());
  int flags = member.body->getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK;
  if (object.motion != nullptr || object.commanded != nullptr || object.is_movable) flags |= btCollisionObject::CF_KINEMATIC_OBJECT;
  member.body->setCollisionFlags(flags);
  return member;
}

// Simplifies the mesh first, within half of the tolerance, which makes the number of convex pieces smaller.
void make_body_shape(const TriangleMesh& touched_mesh, const Pose& X_BS, Member& member) {
  TriangleMesh mesh = {touched_mesh.vertices, touched_mesh.triangles};
  const double tolerance_m = DynamicsWorld::kShapeShare * compute_bounds(mesh).extent();
  (void)simplify_small(mesh, tolerance_m / 2);  // an error leaves the mesh as it is
  const std::vector<ConvexPiece> pieces = split_into_convex(mesh, tolerance_m, kMaxPieces);
  if (pieces.size() == 1) {
    member.shape = make_hull(pieces.front(), X_BS);
    return;
  }
  auto compound = std::make_unique<btCompoundShape>(true, static_cast<int>(pieces.size()));
  for (const ConvexPiece& piece : pieces) {
    member.pieces.push_back(make_hull(piece, X_BS));
    compound->addChildShape(btTransform::getIdentity(), member.pieces.back().get());
  }
  member.shape = std::move(compound);
}

Result<Member> make_body(const SceneObject& object) {
  const auto properties = compute_mass_properties(*object.mesh);
  if (!properties) {
    return fail(
        "object '{}' has a mass, but its surface is not closed, or faces inwards, so that its inertia is unknown: `hapton info` "
        "shows where it is open; repair it, or leave out 'mass_kg'",
        object.name);
  }
  const BodyFrame frame = find_frame(*properties);
  Member member;
  member.has_mass = true;
  member.X_SB = frame.X_SB;
  member.pivot_S = object.commanded->pivot();
  member.radius_m = object.commanded->radius_m();
  const Pose X_BS = frame.X_SB.inverse(Eigen::Isometry);
  make_body_shape(*object.mesh, X_BS, member);
  const btVector3 inertia = to_bullet(object.mass_kg * kUnitsPerM * kUnitsPerM * frame.inertia_per_mass);
  member.body = std::make_unique<btRigidBody>(btScalar(object.mass_kg), nullptr, member.shape.get(), inertia);
  member.body->setWorldTransform(to_bullet(member.X_SB));
  member.body->setSleepingThresholds(btScalar(kSleepMPerS * kUnitsPerM), btScalar(kSleepRadPerS));
  return member;
}

}  // namespace

struct DynamicsWorld::Parts {
  Parts() : dispatcher(&configuration), world(&dispatcher, &broadphase, &solver, &configuration) {
    gContactAddedCallback = smooth_edge;
    world.getSolverInfo().m_numIterations = kSolverIterations;
    // Bodies that overlap come apart without getting a velocity.
    world.getSolverInfo().m_splitImpulse = 1;
    world.getSolverInfo().m_splitImpulsePenetrationThreshold = btScalar(-kMarginM * kUnitsPerM);
  }
  ~Parts() {
    for (Member& member : members) world.removeRigidBody(member.body.get());
  }

  void add(Member member, double friction) {
    // Bullet multiplies the friction coefficients of the two bodies in contact. With the square root in each, the product is `friction`.
    member.body->setFriction(btScalar(std::sqrt(friction)));
    member.body->setRestitution(0);
    world.addRigidBody(member.body.get());
    members.push_back(std::move(member));
  }

  // Applies the linear and angular impulse J of one step dt at the contact point. K is the change of the body's velocity at that point by a
  // unit of impulse. The velocity v' after the step follows implicitly from push F and damping B together: v' = v + K J and
  // J = F dt - B dt v', so v' = (1 + K B dt)^-1 (v + K F dt). The implicit step is stable for any mass and damping.
  void apply_push() {
    btRigidBody& body = *at(push->object).body;
    body.activate(true);
    const Vec3 arm = push->p_S - from_bullet(body.getCenterOfMassPosition()) / kUnitsPerM;
    Mat3 inverse_inertia;  // about the centre of mass
    for (int column = 0; column < 3; ++column)
      inverse_inertia.col(column) = kUnitsPerM * kUnitsPerM * from_bullet(body.getInvInertiaTensorWorld().getColumn(column));
    const Mat3 cross = cross_matrix(arm);
    Mat6 K;
    K.topLeftCorner<3, 3>() = body.getInvMass() * Mat3::Identity() - cross * inverse_inertia * cross;
    K.topRightCorner<3, 3>() = -cross * inverse_inertia;
    K.bottomLeftCorner<3, 3>() = inverse_inertia * cross;
    K.bottomRightCorner<3, 3>() = inverse_inertia;
    Vec6 velocity;
    velocity << from_bullet(body.getVelocityInLocalPoint(to_units(arm))) / kUnitsPerM, from_bullet(body.getAngularVelocity());
    Vec6 push_impulse;
    push_impulse << kStepS * push->force_n, kStepS * push->torque_nm;
    Vec6 impulse_per_speed;  // the diagonal of B dt
    impulse_per_speed << Vec3::Constant(kStepS * push->damping_ns_per_m), Vec3::Constant(kStepS * push->damping_nms_per_rad);
    const Mat6 implicit_matrix = Mat6::Identity() + K * impulse_per_speed.asDiagonal();
    const Vec6 velocity_after = implicit_matrix.partialPivLu().solve(velocity + K * push_impulse);
    const Vec6 impulse = push_impulse - impulse_per_speed.asDiagonal() * velocity_after;
    body.applyImpulse(to_units(impulse.head<3>()), to_units(arm));
    body.applyTorqueImpulse(kUnitsPerM * to_units(impulse.tail<3>()));
  }

  // Limits the speed as compute_move_time_s defines it: that of the pivot plus that of the farthest point about the pivot.
  static void limit_speed(Member& member) {
    btRigidBody& body = *member.body;
    const Vec3 arm = pose_of(member).linear() * (member.X_SB.inverse(Eigen::Isometry) * member.pivot_S);  // centre of mass to pivot
    const btVector3 velocity = body.getVelocityInLocalPoint(to_units(arm));
    const double speed = velocity.length() / kUnitsPerM + body.getAngularVelocity().length() * member.radius_m;
    if (speed <= kMaxSurfaceSpeed) return;
    const btScalar share = btScalar(kMaxSurfaceSpeed / speed);
    body.setLinearVelocity(body.getLinearVelocity() * share);
    body.setAngularVelocity(body.getAngularVelocity() * share);
  }

  static Pose pose_of(const Member& member) { return from_bullet(member.body->getWorldTransform()); }

  static void put_back(Member& member) {
    member.body->setWorldTransform(to_bullet(member.X_SB));
    member.body->setInterpolationWorldTransform(to_bullet(member.X_SB));
    member.body->setLinearVelocity(btVector3(0, 0, 0));
    member.body->setAngularVelocity(btVector3(0, 0, 0));
    member.body->clearForces();
    member.body->activate(true);
  }

  void wake_bodies() {
    for (const int object : bodies) at(object).body->activate(true);
  }

  const Member& at(int object) const { return members[static_cast<std::size_t>(object)]; }
  Member& at(int object) { return members[static_cast<std::size_t>(object)]; }

  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher;
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world;
  std::vector<Member> members;  // by number of the object
  std::vector<int> bodies;
  std::optional<Push> push;
  Eigen::AlignedBox3d scene_bounds;  // bounds of the scene as the file places it
  std::vector<int> fallen;           // objects that fell out of the scene in the last step
};

Result<std::unique_ptr<DynamicsWorld>> DynamicsWorld::make(const Scene& scene, double friction) {
  auto parts = std::make_unique<Parts>();
  for (const SceneObject& object : scene.objects) {
    for (const Vec3& vertex : object.mesh->vertices) parts->scene_bounds.extend(vertex);
    if (!(object.mass_kg > 0.0)) {
      parts->add(make_obstacle(object), friction);
      continue;
    }
    auto body = make_body(object);
    if (!body) return tl::unexpected(body.error());
    parts->bodies.push_back(static_cast<int>(parts->members.size()));
    parts->add(std::move(*body), friction);
  }
  if (parts->bodies.empty()) {
    return fail("no object of the scene has a mass; give one 'moved_by = \"program\"' and 'mass_kg', as in scenes/push.toml");
  }
  return std::unique_ptr<DynamicsWorld>(new DynamicsWorld(std::move(parts)));
}

DynamicsWorld::DynamicsWorld(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
DynamicsWorld::~DynamicsWorld() = default;

std::span<const int> DynamicsWorld::bodies() const noexcept { return parts_->bodies; }

bool DynamicsWorld::is_body(int object) const noexcept {
  return object >= 0 && object < static_cast<int>(parts_->members.size()) && parts_->at(object).has_mass;
}

void DynamicsWorld::set_gravity(const Vec3& g_S) {
  parts_->wake_bodies();  // before setGravity, because Bullet gives gravity only to bodies that are awake
  parts_->world.setGravity(to_units(g_S));
}

void DynamicsWorld::press(const std::optional<Push>& push) { parts_->push = push; }

void DynamicsWorld::move_obstacle(int object, const Pose& X_SO) {
  btRigidBody& body = *parts_->at(object).body;
  const btTransform X = to_bullet(X_SO);
  if (X == body.getWorldTransform()) return;
  body.setWorldTransform(X);
  body.activate(true);
  parts_->wake_bodies();
}

void DynamicsWorld::pick_up_obstacle(int object) {
  btRigidBody& body = *parts_->at(object).body;
  if (!body.hasContactResponse()) return;
  body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
  parts_->wake_bodies();
}

void DynamicsWorld::put_down_obstacle(int object, const Pose& X_SO) {
  btRigidBody& body = *parts_->at(object).body;
  const btTransform X = to_bullet(X_SO);
  if (body.hasContactResponse() && X == body.getWorldTransform()) return;
  body.setCollisionFlags(body.getCollisionFlags() & ~btCollisionObject::CF_NO_CONTACT_RESPONSE);
  body.setWorldTransform(X);
  // Bullet takes the difference of the two transforms as the obstacle's velocity: with both equal it is zero.
  body.setInterpolationWorldTransform(X);
  parts_->wake_bodies();
}

void DynamicsWorld::step() {
  if (parts_->push) parts_->apply_push();
  parts_->world.stepSimulation(btScalar(kStepS), 0);
  parts_->fallen.clear();
  for (const int object : parts_->bodies) {
    Member& member = parts_->at(object);
    Parts::limit_speed(member);
    const Vec3 offset = Parts::pose_of(member).translation() - parts_->scene_bounds.center();
    if (offset.norm() <= kFallenDiagonals * parts_->scene_bounds.diagonal().norm()) continue;
    Parts::put_back(member);
    parts_->fallen.push_back(object);
  }
}

Keyframe DynamicsWorld::place(int object, double ahead_s) const {
  const Member& member = parts_->at(object);
  btTransform X = member.body->getWorldTransform();
  if (ahead_s > 0.0) {
    btTransformUtil::integrateTransform(member.body->getWorldTransform(), member.body->getLinearVelocity(),
                                        member.body->getAngularVelocity(), btScalar(ahead_s), X);
  }
  const Pose X_SO = from_bullet(X) * member.X_SB.inverse(Eigen::Isometry);
  return {.p_S = X_SO * member.pivot_S, .turn = Quat(X_SO.linear())};
}

std::span<const int> DynamicsWorld::fallen() const noexcept { return parts_->fallen; }

#endif

}  // namespace hapton::dynamics
