#include "vision_node/xr/headset.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <GL/glew.h>
#include <fmt/format.h>

#include "vision_node/xr/openxr_error.h"

// Included after all others: Xlib's macros (None, Success, Bool ...) break other headers.
#include <X11/Xlib.h>
// Included after Xlib.h.
#include <GL/glx.h>
#define XR_USE_PLATFORM_XLIB
#define XR_USE_GRAPHICS_API_OPENGL
// Included after the headers that the two macros require.
#include <openxr/openxr.h>
// Included after openxr.h.
#include <openxr/openxr_platform.h>

namespace hapton {
namespace {

constexpr XrViewConfigurationType kStereo = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
constexpr XrPosef kNoMotion = {{0, 0, 0, 1}, {0, 0, 0}};
// How long the destructor waits for the runtime to end the session.
constexpr std::chrono::milliseconds kLongestSessionEnd{1000};

template <class T>
T make_struct(XrStructureType type) {
  T made{};
  made.type = type;
  return made;
}

// None: the pose is not rigid, or not finite. OpenXR gives unit quaternions in single precision.
std::optional<Pose> to_pose(const XrPosef& pose) {
  constexpr double kOffUnit = 0.01;  // far above the rounding of single precision
  const Quat q(pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z);
  const Vec3 p(pose.position.x, pose.position.y, pose.position.z);
  if (!(std::abs(q.norm() - 1.0) < kOffUnit) || !p.allFinite()) return std::nullopt;
  return Eigen::Translation3d(p) * Pose(q.normalized());
}

FieldOfView to_fov(const XrFovf& fov) { return {fov.angleLeft, fov.angleRight, fov.angleUp, fov.angleDown}; }

// The format of the textures: of those that we can use, in our order of preference, the first that the runtime offers. Our images are
// encoded in sRGB: an sRGB format declares that, so that the headset shows the same colours as the window.
std::optional<std::int64_t> choose_format(const std::vector<std::int64_t>& offered) {
  for (const std::int64_t wanted : {GL_SRGB8_ALPHA8, GL_SRGB8, GL_RGBA8, GL_RGB8}) {
    if (std::ranges::find(offered, wanted) != offered.end()) return wanted;
  }
  return std::nullopt;
}

std::string version_text(XrVersion version) { return fmt::format("{}.{}", XR_VERSION_MAJOR(version), XR_VERSION_MINOR(version)); }

}  // namespace

struct Headset::Runtime {
  XrInstance instance = XR_NULL_HANDLE;
  XrSystemId system = XR_NULL_SYSTEM_ID;
  XrEnvironmentBlendMode blend = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
  std::string name;
  PictureSize size;
  XrSession session = XR_NULL_HANDLE;
  XrSpace space = XR_NULL_HANDLE;
  struct Swapchain {
    XrSwapchain handle = XR_NULL_HANDLE;
    std::vector<XrSwapchainImageOpenGLKHR> images;
  };
  std::array<Swapchain, 2> swapchains;
  bool is_running = false;
  bool has_ended = false;
  std::string loss;  // why the runtime is lost; empty: it is not
  XrTime frame_time = 0;
  bool has_frame = false;  // a frame was begun and not ended
  bool has_eyes = false;   // `views` and `eyes` were set at least once
  std::array<XrView, 2> views = {make_struct<XrView>(XR_TYPE_VIEW), make_struct<XrView>(XR_TYPE_VIEW)};
  std::array<EyeInFrame, 2> eyes;

  ~Runtime() { destroy(); }

  // Returns false and marks the runtime as lost if the call failed.
  bool check(XrResult result, std::string_view call) {
    if (XR_SUCCEEDED(result)) return true;
    mark_lost(fmt::format("{}: {}", call, openxr_name(result)));
    return false;
  }
  void mark_lost(std::string why) {
    if (loss.empty()) loss = std::move(why);
    is_running = has_frame = false;
  }

  Result<void> make_instance();
  Result<void> find_system();
  Result<void> make_session(const GlxWindow& window);
  Result<void> check_graphics() const;
  Result<void> make_space(RoomSpace room);
  Result<void> make_swapchains();
  void handle_state(XrSessionState state);
  void locate_eyes();
  bool fill_swapchains(const CopyEye& copy, std::array<XrCompositionLayerProjectionView, 2>& shown);
  void finish_frame(const XrCompositionLayerProjection* layer);
  void destroy();
};

Result<void> Headset::Runtime::make_instance() {
  // The loader prints several lines for an error that we explain in one. XR_LOADER_DEBUG=all shows them.
  setenv("XR_LOADER_DEBUG", "none", 0);
  std::uint32_t count = 0;
  if (const XrResult result = xrEnumerateInstanceExtensionProperties(nullptr, 0, &count, nullptr); XR_FAILED(result)) {
    return tl::unexpected(explain_openxr(result, "xrEnumerateInstanceExtensionProperties"));
  }
  std::vector<XrExtensionProperties> known(count, make_struct<XrExtensionProperties>(XR_TYPE_EXTENSION_PROPERTIES));
  if (const XrResult result = xrEnumerateInstanceExtensionProperties(nullptr, count, &count, known.data()); XR_FAILED(result)) {
    return tl::unexpected(explain_openxr(result, "xrEnumerateInstanceExtensionProperties"));
  }
  const auto is_opengl = [](const XrExtensionProperties& each) {
    return std::strcmp(each.extensionName, XR_KHR_OPENGL_ENABLE_EXTENSION_NAME) == 0;
  };
  if (std::ranges::none_of(known, is_opengl)) {
    return fail("--stereo openxr: the OpenXR runtime does not support OpenGL ({}); make another runtime the active one",
                XR_KHR_OPENGL_ENABLE_EXTENSION_NAME);
  }
  const char* const extensions[] = {XR_KHR_OPENGL_ENABLE_EXTENSION_NAME};
  auto info = make_struct<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
  std::strcpy(info.applicationInfo.applicationName, "Hapton");
  info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
  info.enabledExtensionCount = 1;
  info.enabledExtensionNames = extensions;
  if (const XrResult made = xrCreateInstance(&info, &instance); XR_FAILED(made))
    return tl::unexpected(explain_openxr(made, "xrCreateInstance"));
  auto facts = make_struct<XrInstanceProperties>(XR_TYPE_INSTANCE_PROPERTIES);
  if (XR_SUCCEEDED(xrGetInstanceProperties(instance, &facts))) name = facts.runtimeName;
  return {};
}

Result<void> Headset::Runtime::find_system() {
  auto info = make_struct<XrSystemGetInfo>(XR_TYPE_SYSTEM_GET_INFO);
  info.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
  if (const XrResult found = xrGetSystem(instance, &info, &system); XR_FAILED(found)) {
    return tl::unexpected(explain_openxr(found, "xrGetSystem"));
  }
  std::array<XrViewConfigurationView, 2> each = {make_struct<XrViewConfigurationView>(XR_TYPE_VIEW_CONFIGURATION_VIEW),
                                                 make_struct<XrViewConfigurationView>(XR_TYPE_VIEW_CONFIGURATION_VIEW)};
  std::uint32_t count = 0;
  const XrResult found = xrEnumerateViewConfigurationViews(instance, system, kStereo, each.size(), &count, each.data());
  if (XR_FAILED(found)) return tl::unexpected(explain_openxr(found, "xrEnumerateViewConfigurationViews"));
  if (count != each.size()) return fail("--stereo openxr: the OpenXR runtime has {} views in place of one for each eye", count);
  size.width_px = static_cast<int>(std::max(each[0].recommendedImageRectWidth, each[1].recommendedImageRectWidth));
  size.height_px = static_cast<int>(std::max(each[0].recommendedImageRectHeight, each[1].recommendedImageRectHeight));
  std::array<XrEnvironmentBlendMode, 16> blends{};
  const XrResult listed =
      xrEnumerateEnvironmentBlendModes(instance, system, kStereo, static_cast<std::uint32_t>(blends.size()), &count, blends.data());
  if (XR_SUCCEEDED(listed) && count > 0 && std::find(blends.begin(), blends.begin() + count, blend) == blends.begin() + count) {
    blend = blends.front();
  }
  return {};
}

// OpenXR requires this call before a session is created (XR_KHR_opengl_enable).
Result<void> Headset::Runtime::check_graphics() const {
  PFN_xrGetOpenGLGraphicsRequirementsKHR get_requirements = nullptr;
  xrGetInstanceProcAddr(instance, "xrGetOpenGLGraphicsRequirementsKHR", reinterpret_cast<PFN_xrVoidFunction*>(&get_requirements));
  auto requirements = make_struct<XrGraphicsRequirementsOpenGLKHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_OPENGL_KHR);
  if (get_requirements == nullptr)
    return tl::unexpected(explain_openxr(XR_ERROR_FUNCTION_UNSUPPORTED, "xrGetOpenGLGraphicsRequirementsKHR"));
  if (const XrResult result = get_requirements(instance, system, &requirements); XR_FAILED(result)) {
    return tl::unexpected(explain_openxr(result, "xrGetOpenGLGraphicsRequirementsKHR"));
  }
  GLint major = 0;
  GLint minor = 0;
  glGetIntegerv(GL_MAJOR_VERSION, &major);
  glGetIntegerv(GL_MINOR_VERSION, &minor);
  const XrVersion ours = XR_MAKE_VERSION(static_cast<std::uint64_t>(major), static_cast<std::uint64_t>(minor), 0);
  if (ours >= requirements.minApiVersionSupported) return {};
  return fail("--stereo openxr: the OpenXR runtime needs OpenGL {}, and this display has {}; install a newer graphics driver",
              version_text(requirements.minApiVersionSupported), version_text(ours));
}

Result<void> Headset::Runtime::make_session(const GlxWindow& window) {
  if (auto fits = check_graphics(); !fits) return fits;
  auto binding = make_struct<XrGraphicsBindingOpenGLXlibKHR>(XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR);
  binding.xDisplay = static_cast<Display*>(window.display);
  binding.visualid = window.visual_id;
  binding.glxFBConfig = static_cast<GLXFBConfig>(window.framebuffer_config);
  binding.glxDrawable = window.drawable;
  binding.glxContext = static_cast<GLXContext>(window.context);
  auto info = make_struct<XrSessionCreateInfo>(XR_TYPE_SESSION_CREATE_INFO);
  info.next = &binding;
  info.systemId = system;
  if (const XrResult made = xrCreateSession(instance, &info, &session); XR_FAILED(made)) {
    return tl::unexpected(explain_openxr(made, "xrCreateSession"));
  }
  return {};
}

Result<void> Headset::Runtime::make_space(RoomSpace room) {
  auto info = make_struct<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
  info.referenceSpaceType = room == RoomSpace::stage ? XR_REFERENCE_SPACE_TYPE_STAGE : XR_REFERENCE_SPACE_TYPE_LOCAL;
  info.poseInReferenceSpace = kNoMotion;
  const XrResult made = xrCreateReferenceSpace(session, &info, &space);
  if (XR_SUCCEEDED(made)) return {};
  if (made == XR_ERROR_REFERENCE_SPACE_UNSUPPORTED) {
    return fail("--room stage: the OpenXR runtime does not know where the floor is; set up its room, or use --room local");
  }
  return tl::unexpected(explain_openxr(made, "xrCreateReferenceSpace"));
}

Result<void> Headset::Runtime::make_swapchains() {
  std::uint32_t count = 0;
  std::vector<std::int64_t> formats;
  XrResult result = xrEnumerateSwapchainFormats(session, 0, &count, nullptr);
  if (XR_SUCCEEDED(result)) {
    formats.resize(count);
    result = xrEnumerateSwapchainFormats(session, count, &count, formats.data());
  }
  const auto format = choose_format(formats);
  if (XR_FAILED(result)) return tl::unexpected(explain_openxr(result, "xrEnumerateSwapchainFormats"));
  if (!format)
    return fail("--stereo openxr: the OpenXR runtime offers no texture with 8 bits a colour; make another runtime the active one");
  auto info = make_struct<XrSwapchainCreateInfo>(XR_TYPE_SWAPCHAIN_CREATE_INFO);
  info.usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT | XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT;
  info.format = *format;
  info.sampleCount = info.faceCount = info.arraySize = info.mipCount = 1;
  info.width = static_cast<std::uint32_t>(size.width_px);
  info.height = static_cast<std::uint32_t>(size.height_px);
  for (Swapchain& chain : swapchains) {
    result = xrCreateSwapchain(session, &info, &chain.handle);
    if (XR_SUCCEEDED(result)) result = xrEnumerateSwapchainImages(chain.handle, 0, &count, nullptr);
    if (XR_FAILED(result)) return tl::unexpected(explain_openxr(result, "xrCreateSwapchain"));
    chain.images.assign(count, make_struct<XrSwapchainImageOpenGLKHR>(XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR));
    result = xrEnumerateSwapchainImages(chain.handle, count, &count, reinterpret_cast<XrSwapchainImageBaseHeader*>(chain.images.data()));
    if (XR_FAILED(result)) return tl::unexpected(explain_openxr(result, "xrEnumerateSwapchainImages"));
  }
  return {};
}

void Headset::Runtime::handle_state(XrSessionState state) {
  switch (state) {
    case XR_SESSION_STATE_READY: {
      auto info = make_struct<XrSessionBeginInfo>(XR_TYPE_SESSION_BEGIN_INFO);
      info.primaryViewConfigurationType = kStereo;
      is_running = check(xrBeginSession(session, &info), "xrBeginSession");
      break;
    }
    case XR_SESSION_STATE_STOPPING:
      is_running = has_frame = false;
      check(xrEndSession(session), "xrEndSession");
      break;
    case XR_SESSION_STATE_EXITING:
      is_running = false;
      has_ended = true;
      break;
    case XR_SESSION_STATE_LOSS_PENDING:
      mark_lost("the runtime is about to end");
      break;
    default:
      break;
  }
}

// Sets `views` and `eyes` for the time of the frame. If a pose is not known or not rigid, they stay as they are.
void Headset::Runtime::locate_eyes() {
  auto info = make_struct<XrViewLocateInfo>(XR_TYPE_VIEW_LOCATE_INFO);
  info.viewConfigurationType = kStereo;
  info.displayTime = frame_time;
  info.space = space;
  auto state = make_struct<XrViewState>(XR_TYPE_VIEW_STATE);
  std::array<XrView, 2> new_views = {make_struct<XrView>(XR_TYPE_VIEW), make_struct<XrView>(XR_TYPE_VIEW)};
  std::uint32_t count = 0;
  if (!check(xrLocateViews(session, &info, &state, new_views.size(), &count, new_views.data()), "xrLocateViews")) return;
  constexpr XrViewStateFlags kKnown = XR_VIEW_STATE_POSITION_VALID_BIT | XR_VIEW_STATE_ORIENTATION_VALID_BIT;
  if (count != new_views.size() || (state.viewStateFlags & kKnown) != kKnown) return;
  std::array<EyeInFrame, 2> new_eyes;
  for (std::size_t i = 0; i < new_views.size(); ++i) {
    const auto X_LE = to_pose(new_views[i].pose);
    if (!X_LE || !is_possible(to_fov(new_views[i].fov))) return;
    new_eyes[i] = {*X_LE, to_fov(new_views[i].fov)};
  }
  views = new_views;
  eyes = new_eyes;
  has_eyes = true;
}

bool Headset::Runtime::fill_swapchains(const CopyEye& copy, std::array<XrCompositionLayerProjectionView, 2>& shown) {
  for (std::size_t eye = 0; eye < swapchains.size(); ++eye) {
    const Swapchain& chain = swapchains[eye];
    std::uint32_t index = 0;
    if (!check(xrAcquireSwapchainImage(chain.handle, nullptr, &index), "xrAcquireSwapchainImage")) return false;
    auto wait = make_struct<XrSwapchainImageWaitInfo>(XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO);
    wait.timeout = XR_INFINITE_DURATION;
    if (!check(xrWaitSwapchainImage(chain.handle, &wait), "xrWaitSwapchainImage")) return false;
    if (index < chain.images.size()) copy(eye, chain.images[index].image);
    if (!check(xrReleaseSwapchainImage(chain.handle, nullptr), "xrReleaseSwapchainImage")) return false;
    shown[eye] = make_struct<XrCompositionLayerProjectionView>(XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW);
    shown[eye].pose = views[eye].pose;
    shown[eye].fov = views[eye].fov;
    shown[eye].subImage.swapchain = chain.handle;
    shown[eye].subImage.imageRect.extent = {size.width_px, size.height_px};
  }
  return true;
}

void Headset::Runtime::finish_frame(const XrCompositionLayerProjection* layer) {
  has_frame = false;
  auto ended = make_struct<XrFrameEndInfo>(XR_TYPE_FRAME_END_INFO);
  ended.displayTime = frame_time;
  ended.environmentBlendMode = blend;
  const XrCompositionLayerBaseHeader* const layers[] = {reinterpret_cast<const XrCompositionLayerBaseHeader*>(layer)};
  ended.layerCount = layer != nullptr ? 1 : 0;
  ended.layers = layer != nullptr ? layers : nullptr;
  check(xrEndFrame(session, &ended), "xrEndFrame");
}

void Headset::Runtime::destroy() {
  for (Swapchain& chain : swapchains) {
    if (chain.handle != XR_NULL_HANDLE) xrDestroySwapchain(std::exchange(chain.handle, XR_NULL_HANDLE));
  }
  if (space != XR_NULL_HANDLE) xrDestroySpace(std::exchange(space, XR_NULL_HANDLE));
  if (session != XR_NULL_HANDLE) xrDestroySession(std::exchange(session, XR_NULL_HANDLE));
  if (instance != XR_NULL_HANDLE) xrDestroyInstance(std::exchange(instance, XR_NULL_HANDLE));
}

Headset::Headset(std::unique_ptr<Runtime> runtime) : runtime_(std::move(runtime)) {}

Result<std::unique_ptr<Headset>> Headset::connect() {
  auto runtime = std::make_unique<Runtime>();
  if (auto made = runtime->make_instance(); !made) return tl::unexpected(made.error());
  if (auto found = runtime->find_system(); !found) return tl::unexpected(found.error());
  return std::unique_ptr<Headset>(new Headset(std::move(runtime)));
}

// The runtime ends a session in several steps, and requires frames until then.
Headset::~Headset() {
  if (runtime_->has_frame) runtime_->finish_frame(nullptr);
  if (!is_running() || XR_FAILED(xrRequestExitSession(runtime_->session))) return;
  const auto until = std::chrono::steady_clock::now() + kLongestSessionEnd;
  while (is_running() && std::chrono::steady_clock::now() < until) {
    poll_events();
    if (is_running() && begin_frame()) runtime_->finish_frame(nullptr);
  }
}

const std::string& Headset::name() const { return runtime_->name; }
PictureSize Headset::eye_size() const { return runtime_->size; }

Result<void> Headset::open(const GlxWindow& window, RoomSpace space) {
  if (auto made = runtime_->make_session(window); !made) return made;
  if (auto made = runtime_->make_space(space); !made) return made;
  return runtime_->make_swapchains();
}

void Headset::poll_events() {
  while (!is_lost()) {
    auto event = make_struct<XrEventDataBuffer>(XR_TYPE_EVENT_DATA_BUFFER);
    const XrResult polled = xrPollEvent(runtime_->instance, &event);
    if (polled == XR_EVENT_UNAVAILABLE || !runtime_->check(polled, "xrPollEvent")) return;
    if (event.type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING) runtime_->mark_lost("the runtime is about to end");
    if (event.type != XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) continue;
    XrEventDataSessionStateChanged changed;
    std::memcpy(&changed, &event, sizeof changed);
    if (changed.session == runtime_->session) runtime_->handle_state(changed.state);
  }
}

bool Headset::is_running() const { return runtime_->is_running; }
bool Headset::has_ended() const { return runtime_->has_ended; }
bool Headset::is_lost() const { return !runtime_->loss.empty(); }
const std::string& Headset::loss() const { return runtime_->loss; }
const std::array<EyeInFrame, 2>& Headset::eyes() const { return runtime_->eyes; }

bool Headset::begin_frame() {
  Runtime& runtime = *runtime_;
  auto frame_state = make_struct<XrFrameState>(XR_TYPE_FRAME_STATE);
  if (!runtime.check(xrWaitFrame(runtime.session, nullptr, &frame_state), "xrWaitFrame")) return false;
  if (!runtime.check(xrBeginFrame(runtime.session, nullptr), "xrBeginFrame")) return false;
  runtime.has_frame = true;
  runtime.frame_time = frame_state.predictedDisplayTime;
  if (frame_state.shouldRender != XR_FALSE) runtime.locate_eyes();
  if (frame_state.shouldRender != XR_FALSE && runtime.has_eyes && !is_lost()) return true;
  if (runtime.has_frame) runtime.finish_frame(nullptr);
  return false;
}

void Headset::end_frame(const CopyEye& copy) {
  Runtime& runtime = *runtime_;
  if (!runtime.has_frame) return;
  std::array<XrCompositionLayerProjectionView, 2> shown;
  if (!copy) return runtime.finish_frame(nullptr);
  if (!runtime.fill_swapchains(copy, shown)) return;
  auto layer = make_struct<XrCompositionLayerProjection>(XR_TYPE_COMPOSITION_LAYER_PROJECTION);
  layer.space = runtime.space;
  layer.viewCount = shown.size();
  layer.views = shown.data();
  runtime.finish_frame(&layer);
}

}  // namespace hapton
