#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <thread>

#include "core/base/mailbox.h"
#include "core/force/force_method.h"
#include "core/force/touch_scene.h"
#include "core/force/touch_step.h"
#include "haptics_node/new_scene.h"
#include "link/messages.h"

namespace hapton {

// Makes a force method for a scene, as make_method does; may replace settings.name by the full name. Threads: one at a time.
using MakeMethod = std::function<Result<std::unique_ptr<ForceMethod>>(MethodSettings& settings, const TouchScene& scene)>;
Result<std::unique_ptr<ForceMethod>> make_built_in(MethodSettings& settings, const TouchScene& scene);

// A force method, ready for use.
struct BuiltMethod {
  std::unique_ptr<TouchStep> step;
  HapticsSetup::Text text = {};                     // for HapticsSetup::method
  std::uint32_t request_id = 0;                     // as in Settings::method_request; 0: not requested by name
  std::shared_ptr<const NewScene> scene = nullptr;  // the new scene that it was made for; null: the scene in use
};

// A method that cannot be built.
struct RejectedMethod {
  std::uint32_t request_id = 0;
  HapticsSetup::Text why = {};
};

// Builds force methods for a scene in its own thread, and frees those no longer needed, so that the loop that replies to the device neither
// builds nor frees anything. Its thread is also the slow task of the method in use: it builds what that method's steps request
// (ForceMethod::prepare). A method that cannot be built is logged and reported, and the current one stays in use. A method that replaces
// another one in contact is built completely, not on approach. RT: request, take, take_rejection, retire and idle_polls yes; the rest
// set-up only. Threads: one caller; rebuild_for from another one.
class MethodBuilder {
 public:
  using MethodName = std::array<char, 16>;  // NUL-padded

  MethodBuilder(MethodSettings settings, TouchScene scene, std::weak_ptr<ForceMethod> in_use = {}, MakeMethod make = make_built_in);
  ~MethodBuilder();
  MethodBuilder(const MethodBuilder&) = delete;
  MethodBuilder& operator=(const MethodBuilder&) = delete;

  // Requests a method by name; replaces an earlier request that has not started.
  void request(const MethodName& name, std::uint32_t request_id = 0) noexcept { requests_.publish({name, request_id}); }

  // Builds the method in use for another scene, or keeps it if the meshes are the same (NewScene::keeps_shape); later methods are built for
  // that scene, too. Waits until take() can return the result. Error, one line: the method cannot be built; the present scene stays in use.
  // Threads: any except the caller of take, one at a time. RT: no.
  Result<void> rebuild_for(std::shared_ptr<const NewScene> scene);

  // How often the slow task found nothing to do. Once this number has risen by two, everything requested before is built.
  std::uint64_t idle_polls() const noexcept { return idle_polls_.load(std::memory_order_acquire); }

  // The newest method that is built and not yet taken; null: there is none.
  std::unique_ptr<BuiltMethod> take() noexcept;

  // The newest rejection that is not yet taken; null: there is none. The pointer is valid until the next call.
  const RejectedMethod* take_rejection() noexcept { return rejections_.take() ? &rejections_.value() : nullptr; }

  // Frees, in the builder's thread, an object that take() has returned and that now holds the replaced method.
  void retire(std::unique_ptr<BuiltMethod> method) noexcept { retired_.store(method.release(), std::memory_order_release); }

 private:
  struct Request {
    MethodName name = {};
    std::uint32_t request_id = 0;
  };

  void run();
  void build(const Request& request);
  void build_requested_scene();
  Result<void> build_scene(const std::shared_ptr<const NewScene>& scene);
  void publish(std::unique_ptr<BuiltMethod> ready);
  bool prepare();
  void free_retired() noexcept { delete retired_.exchange(nullptr, std::memory_order_acq_rel); }

  MakeMethod make_;
  MethodSettings settings_;
  TouchScene scene_;
  Mailbox<Request> requests_;
  Mailbox<RejectedMethod> rejections_;
  std::weak_ptr<ForceMethod> method_in_use_;  // the method built last; used by the builder's thread only
  std::atomic<BuiltMethod*> built_ = nullptr;
  std::atomic<BuiltMethod*> retired_ = nullptr;
  std::atomic<std::uint64_t> idle_polls_ = 0;
  std::mutex scene_mutex_;
  std::shared_ptr<const NewScene> next_scene_;  // requested, and its build has not begun; null: none
  std::promise<Result<void>> scene_built_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace hapton
