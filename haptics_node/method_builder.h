#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <thread>

#include "core/force/force_method.h"
#include "core/force/touch_scene.h"
#include "core/force/touch_step.h"
#include "haptics_node/new_scene.h"
#include "link/messages.h"
#include "runtime/mailbox.h"

namespace hapton {

// Makes a method for the scene, as make_method does; may replace the name in the settings by the full one. Threads: one at a time.
using MakeMethod = std::function<Result<std::unique_ptr<ForceMethod>>(MethodSettings& settings, const TouchScene& scene)>;
Result<std::unique_ptr<ForceMethod>> make_built_in(MethodSettings& settings, const TouchScene& scene);

// A method ready for use.
struct BuiltMethod {
  std::unique_ptr<TouchStep> step;
  HapticsSetup::Text text = {};                     // as in HapticsSetup::method
  std::uint32_t request_id = 0;                     // as in Settings::method_request
  std::shared_ptr<const NewScene> scene = nullptr;  // it was made for this one, which is not in use yet; null: for that in use
};

// A method that cannot be built.
struct RejectedMethod {
  std::uint32_t request_id = 0;
  HapticsSetup::Text why = {};
};

// Builds force methods over one scene in its own thread, and frees those no longer needed, so that the loop that replies to the device
// neither builds nor frees anything. It also is the slow task of the method in use: it prepares what that method's steps request. A
// method that cannot be built is logged and reported, and the current one stays in use. A method that takes over in contact must be
// complete: nothing of it is built on approach. RT: request, take, take_rejection and retire yes; the rest set-up only. Threads: one
// caller.
class MethodBuilder {
 public:
  using MethodName = std::array<char, 16>;  // NUL-padded

  MethodBuilder(MethodSettings settings, TouchScene scene, std::weak_ptr<ForceMethod> in_use = {}, MakeMethod make = make_built_in);
  ~MethodBuilder();
  MethodBuilder(const MethodBuilder&) = delete;
  MethodBuilder& operator=(const MethodBuilder&) = delete;

  // Requests a method; a later request replaces one that has not started.
  void request(const MethodName& name, std::uint32_t request_id = 0) noexcept { requests_.publish({name, request_id}); }

  // Methods are made for this scene from now on; the method in use is made again for it, or kept if the shape is the same. Returns when it
  // is ready to be taken. Error, one line: it cannot be built; the present scene stays in use. Threads: any but the caller of take. RT: no.
  Result<void> rebuild_for(std::shared_ptr<const NewScene> scene);

  // How often the slow task found nothing to do: two more than before mean that everything requested until then is built.
  std::uint64_t idle_polls() const noexcept { return idle_polls_.load(std::memory_order_acquire); }

  // The method built last, once; none when there is no new one.
  std::unique_ptr<BuiltMethod> take() noexcept;

  // The request rejected last, once; none when there is no new one. It stays until the next call.
  const RejectedMethod* take_rejection() noexcept { return rejections_.take() ? &rejections_.value() : nullptr; }

  // Takes back the object that take() returned, now with the method that was replaced, and frees it.
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
  std::weak_ptr<ForceMethod> in_use_;  // this thread's own: the method built last
  std::atomic<BuiltMethod*> built_ = nullptr;
  std::atomic<BuiltMethod*> retired_ = nullptr;
  std::atomic<std::uint64_t> idle_polls_ = 0;
  std::mutex scene_mutex_;
  std::shared_ptr<const NewScene> next_scene_;  // requested, not begun
  std::promise<Result<void>> scene_built_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace hapton
