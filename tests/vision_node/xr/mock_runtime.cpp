// An OpenXR runtime without a headset: it gives the views of mock_views.h, checks the order of calls, and writes the pictures to files.
// XR_RUNTIME_JSON selects it. HAPTON_MOCK_XR holds words KEY or KEY=VALUE, separated by commas:
//   out=FOLDER           for a file frame_NNN_E.ppm of each picture (eye E; 0: left), and log: a line for each frame, wrong call and event
//   width=N height=N     size of each eye's picture in pixels
//   no_opengl no_headset no_stage linear   no OpenGL extension, no headset, no space STAGE, no sRGB format of pictures
//   lose_after=N         calls for events and frames fail after N frames; lose_in=NAME: the first call that fails
//   pending_after=N      the runtime says after N frames that it is about to end
//   exit_after=N         the runtime ends the session after N frames
//   stop_after=N stop_ms=N   the program gets SIGINT after N frames; N ms after the runtime is lost or says that it is about to end
//   crooked_from=N crooked_to=N                      frames whose poses are flagged as valid, though the right eye's is not a rotation
//   still=N              the head is always where it is in frame N
//   opengl_9             requires OpenGL 9, which does not exist
//   hide_from=N hide_to=N, blind_from=N blind_to=N   frames that need no drawing; frames without a pose (_to: the first one after them)
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <fstream>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "tests/vision_node/xr/mock_views.h"

#include <X11/Xlib.h>

#include <GL/gl.h>
#include <GL/glext.h>
#include <GL/glx.h>
#define XR_USE_PLATFORM_XLIB
#define XR_USE_GRAPHICS_API_OPENGL
#include <openxr/openxr.h>

#include <openxr/openxr_platform.h>

#include "tests/vision_node/xr/loader_negotiation.h"

namespace {

using namespace hapton;

constexpr std::size_t kImagesPerSwapchain = 3;

// Handles are addresses of these bytes, whose values nobody reads. 0: the instance, 1: the session, 2: the space; then the swapchains.
char g_handles[8];
template <class Handle>
Handle handle(int number) {
  return reinterpret_cast<Handle>(&g_handles[number]);
}

std::map<std::string, std::string> read_words() {
  std::map<std::string, std::string> words;
  const char* text = std::getenv("HAPTON_MOCK_XR");
  std::string rest = text != nullptr ? text : "";
  while (!rest.empty()) {
    const std::string word = rest.substr(0, rest.find(','));
    rest.erase(0, std::min(rest.size(), word.size() + 1));
    const std::size_t at = word.find('=');
    words[word.substr(0, at)] = at == std::string::npos ? "1" : word.substr(at + 1);
  }
  return words;
}

struct Chain {
  std::vector<GLuint> textures;
  int next = 0;
  int acquired = -1;
  bool is_image_ready = false;
  int shown = -1;  // index of the texture that was released last; -1: none
};

struct Mock {
  std::map<std::string, std::string> words = read_words();
  std::deque<XrEventDataSessionStateChanged> events;
  std::vector<Chain> chains;
  bool has_queried_opengl_version = false;
  bool is_running = false;
  bool is_frame_awaited = false;
  bool is_frame_begun = false;
  bool is_space_stage = false;
  bool is_dead = false;
  int frames = 0;  // number of frames that the program has waited for

  bool has(const std::string& word) const { return words.contains(word); }
  int number(const std::string& word, int otherwise) const { return has(word) ? std::stoi(words.at(word)) : otherwise; }
  bool is_frame_in_range(const std::string& what) const {
    return frames - 1 >= number(what + "_from", 1 << 30) && frames - 1 < number(what + "_to", 1 << 30);
  }
  void stop_later() const {
    if (!has("stop_ms")) return;
    std::thread([milliseconds = number("stop_ms", 0)] {
      std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
      kill(getpid(), SIGINT);
    }).detach();
  }
  // Whether the runtime is lost at this call, or has been lost before.
  bool is_lost(const std::string& call) {
    const bool is_first = !has("lose_in") || words.at("lose_in") == call;
    if (is_dead || !is_first || frames <= number("lose_after", 1 << 30)) return is_dead;
    is_dead = true;
    stop_later();
    return true;
  }
  void log(const std::string& line) const {
    if (has("out")) std::ofstream(words.at("out") + "/log", std::ios::app) << line << '\n';
  }
  XrResult wrong(const std::string& call) const {
    log("wrong: " + call);
    return XR_ERROR_CALL_ORDER_INVALID;
  }
  void enter(XrSessionState state) {
    XrEventDataSessionStateChanged event{};
    event.type = XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED;
    event.session = handle<XrSession>(1);
    event.state = state;
    events.push_back(event);
  }
};
Mock g_mock;

// Ends a call with an error if the runtime is lost.
#define MOCK_RETURN_IF_LOST(call) \
  if (g_mock.is_lost(call)) return XR_ERROR_INSTANCE_LOST

template <class T>
XrResult list(const std::vector<T>& all, uint32_t capacity, uint32_t* count, T* into) {
  *count = static_cast<uint32_t>(all.size());
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < all.size()) return XR_ERROR_SIZE_INSUFFICIENT;
  std::copy(all.begin(), all.end(), into);
  return XR_SUCCESS;
}

XrResult enumerate_extensions(const char*, uint32_t capacity, uint32_t* count, XrExtensionProperties* into) {
  std::vector<XrExtensionProperties> all;
  if (!g_mock.has("no_opengl")) {
    all.push_back({XR_TYPE_EXTENSION_PROPERTIES, nullptr, XR_KHR_OPENGL_ENABLE_EXTENSION_NAME, 9});
  }
  return list(all, capacity, count, into);
}

XrResult create_instance(const XrInstanceCreateInfo* info, XrInstance* made) {
  const bool enables_opengl =
      info->enabledExtensionCount == 1 && std::strcmp(info->enabledExtensionNames[0], XR_KHR_OPENGL_ENABLE_EXTENSION_NAME) == 0;
  if (!enables_opengl) return XR_ERROR_EXTENSION_NOT_PRESENT;
  *made = handle<XrInstance>(0);
  return XR_SUCCESS;
}

XrResult destroy_instance(XrInstance) {
  g_mock.log("destroyed");
  return XR_SUCCESS;
}

XrResult instance_properties(XrInstance, XrInstanceProperties* properties) {
  std::strcpy(properties->runtimeName, "Mock");
  return XR_SUCCESS;
}

XrResult get_system(XrInstance, const XrSystemGetInfo*, XrSystemId* system) {
  if (g_mock.has("no_headset")) return XR_ERROR_FORM_FACTOR_UNAVAILABLE;
  *system = 1;
  return XR_SUCCESS;
}

XrResult configuration_views(XrInstance, XrSystemId, XrViewConfigurationType type, uint32_t capacity, uint32_t* count,
                             XrViewConfigurationView* into) {
  if (type != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO) return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
  XrViewConfigurationView view{};
  view.type = XR_TYPE_VIEW_CONFIGURATION_VIEW;
  view.recommendedImageRectWidth = static_cast<uint32_t>(g_mock.number("width", 320));
  view.recommendedImageRectHeight = static_cast<uint32_t>(g_mock.number("height", 352));
  return list(std::vector<XrViewConfigurationView>(2, view), capacity, count, into);
}

XrResult blend_modes(XrInstance, XrSystemId, XrViewConfigurationType, uint32_t capacity, uint32_t* count, XrEnvironmentBlendMode* into) {
  return list(std::vector<XrEnvironmentBlendMode>{XR_ENVIRONMENT_BLEND_MODE_OPAQUE}, capacity, count, into);
}

XrResult opengl_requirements(XrInstance, XrSystemId, XrGraphicsRequirementsOpenGLKHR* requirements) {
  requirements->minApiVersionSupported = XR_MAKE_VERSION(g_mock.has("opengl_9") ? 9ULL : 3ULL, 2ULL, 0ULL);
  requirements->maxApiVersionSupported = XR_MAKE_VERSION(9ULL, 9ULL, 0ULL);
  g_mock.has_queried_opengl_version = true;
  return XR_SUCCESS;
}

XrResult create_session(XrInstance, const XrSessionCreateInfo* info, XrSession* made) {
  if (!g_mock.has_queried_opengl_version) return XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING;
  const auto* binding = static_cast<const XrGraphicsBindingOpenGLXlibKHR*>(info->next);
  const bool is_complete = binding != nullptr && binding->type == XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR &&
                           binding->xDisplay != nullptr && binding->glxFBConfig != nullptr && binding->visualid != 0 &&
                           binding->glxContext == glXGetCurrentContext() && binding->glxDrawable == glXGetCurrentDrawable() &&
                           glXGetCurrentContext() != nullptr;
  if (!is_complete) return XR_ERROR_GRAPHICS_DEVICE_INVALID;
  *made = handle<XrSession>(1);
  g_mock.enter(XR_SESSION_STATE_IDLE);
  g_mock.enter(XR_SESSION_STATE_READY);
  return XR_SUCCESS;
}

XrResult destroy_session(XrSession) { return XR_SUCCESS; }

XrResult create_space(XrSession, const XrReferenceSpaceCreateInfo* info, XrSpace* made) {
  g_mock.is_space_stage = info->referenceSpaceType == XR_REFERENCE_SPACE_TYPE_STAGE;
  if (g_mock.is_space_stage && g_mock.has("no_stage")) return XR_ERROR_REFERENCE_SPACE_UNSUPPORTED;
  *made = handle<XrSpace>(2);
  return XR_SUCCESS;
}

XrResult destroy_space(XrSpace) { return XR_SUCCESS; }

XrResult formats(XrSession, uint32_t capacity, uint32_t* count, int64_t* into) {
  std::vector<int64_t> all = {GL_RGBA16F, GL_RGBA8};
  if (!g_mock.has("linear")) all.push_back(GL_SRGB8_ALPHA8);
  return list(all, capacity, count, into);
}

XrResult create_chain(XrSession, const XrSwapchainCreateInfo* info, XrSwapchain* made) {
  GLint previous_binding = 0;
  glGetIntegerv(GL_TEXTURE_BINDING_2D, &previous_binding);
  Chain chain;
  chain.textures.resize(kImagesPerSwapchain);
  glGenTextures(kImagesPerSwapchain, chain.textures.data());
  for (const GLuint texture : chain.textures) {
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(info->format), static_cast<GLsizei>(info->width), static_cast<GLsizei>(info->height),
                 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  }
  glBindTexture(GL_TEXTURE_2D, static_cast<GLuint>(previous_binding));
  g_mock.log(fmt::format("format {:#x}", info->format));
  g_mock.chains.push_back(chain);
  *made = handle<XrSwapchain>(2 + static_cast<int>(g_mock.chains.size()));
  return XR_SUCCESS;
}

Chain* find_chain(XrSwapchain swapchain) {
  for (std::size_t i = 0; i < g_mock.chains.size(); ++i) {
    if (swapchain == handle<XrSwapchain>(3 + static_cast<int>(i))) return &g_mock.chains[i];
  }
  return nullptr;
}

XrResult destroy_chain(XrSwapchain swapchain) {
  Chain* chain = find_chain(swapchain);
  if (chain == nullptr) return XR_ERROR_HANDLE_INVALID;
  glDeleteTextures(kImagesPerSwapchain, chain->textures.data());
  return XR_SUCCESS;
}

XrResult chain_images(XrSwapchain swapchain, uint32_t capacity, uint32_t* count, XrSwapchainImageBaseHeader* into) {
  std::vector<XrSwapchainImageOpenGLKHR> all;
  for (const GLuint texture : find_chain(swapchain)->textures) all.push_back({XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR, nullptr, texture});
  return list(all, capacity, count, reinterpret_cast<XrSwapchainImageOpenGLKHR*>(into));
}

XrResult acquire(XrSwapchain swapchain, const XrSwapchainImageAcquireInfo*, uint32_t* index) {
  MOCK_RETURN_IF_LOST("xrAcquireSwapchainImage");
  Chain& chain = *find_chain(swapchain);
  if (chain.acquired >= 0 || !g_mock.is_frame_begun) return g_mock.wrong("xrAcquireSwapchainImage");
  chain.acquired = chain.next;
  chain.next = (chain.next + 1) % static_cast<int>(kImagesPerSwapchain);
  *index = static_cast<uint32_t>(chain.acquired);
  return XR_SUCCESS;
}

XrResult wait_image(XrSwapchain swapchain, const XrSwapchainImageWaitInfo*) {
  MOCK_RETURN_IF_LOST("xrWaitSwapchainImage");
  Chain& chain = *find_chain(swapchain);
  if (chain.acquired < 0 || chain.is_image_ready) return g_mock.wrong("xrWaitSwapchainImage");
  chain.is_image_ready = true;
  return XR_SUCCESS;
}

XrResult release(XrSwapchain swapchain, const XrSwapchainImageReleaseInfo*) {
  MOCK_RETURN_IF_LOST("xrReleaseSwapchainImage");
  Chain& chain = *find_chain(swapchain);
  if (!chain.is_image_ready) return g_mock.wrong("xrReleaseSwapchainImage");
  chain.shown = chain.acquired;
  chain.acquired = -1;
  chain.is_image_ready = false;
  return XR_SUCCESS;
}

XrResult poll_event(XrInstance, XrEventDataBuffer* into) {
  MOCK_RETURN_IF_LOST("xrPollEvent");
  if (g_mock.events.empty()) return XR_EVENT_UNAVAILABLE;
  std::memcpy(into, &g_mock.events.front(), sizeof(XrEventDataSessionStateChanged));
  if (g_mock.events.front().state == XR_SESSION_STATE_LOSS_PENDING) g_mock.stop_later();
  g_mock.events.pop_front();
  return XR_SUCCESS;
}

XrResult begin_session(XrSession, const XrSessionBeginInfo*) {
  if (g_mock.is_running) return XR_ERROR_SESSION_RUNNING;
  g_mock.is_running = true;
  for (const XrSessionState state : {XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_FOCUSED})
    g_mock.enter(state);
  g_mock.log("begun");
  return XR_SUCCESS;
}

XrResult end_session(XrSession) {
  if (!g_mock.is_running) return XR_ERROR_SESSION_NOT_RUNNING;
  g_mock.is_running = false;
  g_mock.enter(XR_SESSION_STATE_IDLE);
  g_mock.enter(XR_SESSION_STATE_EXITING);
  g_mock.log("ended");
  return XR_SUCCESS;
}

XrResult request_exit(XrSession) {
  MOCK_RETURN_IF_LOST("xrRequestExitSession");
  if (!g_mock.is_running) return XR_ERROR_SESSION_NOT_RUNNING;
  g_mock.enter(XR_SESSION_STATE_STOPPING);
  g_mock.log("asked to end");
  return XR_SUCCESS;
}

XrResult wait_frame(XrSession, const XrFrameWaitInfo*, XrFrameState* frame_state) {
  if (!g_mock.is_running || g_mock.is_frame_awaited) return g_mock.wrong("xrWaitFrame");
  std::this_thread::sleep_for(std::chrono::milliseconds(2));
  frame_state->predictedDisplayTime = mock_xr::kFirstFrameNs + g_mock.frames * mock_xr::kPeriodNs;
  frame_state->predictedDisplayPeriod = mock_xr::kPeriodNs;
  ++g_mock.frames;
  MOCK_RETURN_IF_LOST("xrWaitFrame");
  frame_state->shouldRender = g_mock.is_frame_in_range("hide") ? XR_FALSE : XR_TRUE;
  g_mock.is_frame_awaited = true;
  return XR_SUCCESS;
}

XrResult begin_frame(XrSession, const XrFrameBeginInfo*) {
  MOCK_RETURN_IF_LOST("xrBeginFrame");
  if (!g_mock.is_frame_awaited || g_mock.is_frame_begun) return g_mock.wrong("xrBeginFrame");
  g_mock.is_frame_begun = true;
  return XR_SUCCESS;
}

XrPosef to_xr_pose(const Pose& X) {
  const Quat q(X.linear());
  const Vec3 p = X.translation();
  return {{static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()), static_cast<float>(q.w())},
          {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())}};
}

// The newest frame, not after this one, whose pose is known.
int newest_frame_with_pose(int frame) {
  for (const std::string what : {"blind", "crooked"}) {
    const int from = g_mock.number(what + "_from", 1 << 30);
    if (frame >= from && frame < g_mock.number(what + "_to", 1 << 30)) return from - 1;
  }
  return frame;
}

std::array<XrView, 2> views_at(int frame) {
  std::array<XrView, 2> views{};
  const auto eyes = mock_xr::eyes_at(g_mock.number("still", newest_frame_with_pose(frame)));
  for (std::size_t i = 0; i < 2; ++i) {
    Pose X = eyes[i].X_FE;
    if (g_mock.is_space_stage) X.pretranslate(mock_xr::kLocalInStage);
    views[i].type = XR_TYPE_VIEW;
    views[i].pose = to_xr_pose(X);
    const FieldOfView& fov = eyes[i].fov;
    views[i].fov = {static_cast<float>(fov.left_rad), static_cast<float>(fov.right_rad), static_cast<float>(fov.up_rad),
                    static_cast<float>(fov.down_rad)};
  }
  return views;
}

XrResult locate_views(XrSession, const XrViewLocateInfo* info, XrViewState* state, uint32_t capacity, uint32_t* count, XrView* into) {
  MOCK_RETURN_IF_LOST("xrLocateViews");
  if ((info->displayTime - mock_xr::kFirstFrameNs) % mock_xr::kPeriodNs != 0) return XR_ERROR_TIME_INVALID;
  const int frame = static_cast<int>((info->displayTime - mock_xr::kFirstFrameNs) / mock_xr::kPeriodNs);
  auto views = views_at(frame);
  const bool is_crooked = g_mock.is_frame_in_range("crooked");
  if (is_crooked) views[1].pose.orientation = {0, 0, 0, 0};
  state->viewStateFlags =
      newest_frame_with_pose(frame) == frame || is_crooked ? XR_VIEW_STATE_POSITION_VALID_BIT | XR_VIEW_STATE_ORIENTATION_VALID_BIT : 0;
  return list(std::vector<XrView>(views.begin(), views.end()), capacity, count, into);
}

void write_picture(const std::string& name, GLuint texture) {
  GLint previous_binding = 0;
  GLint width = 0;
  GLint height = 0;
  GLint alignment = 0;
  glGetIntegerv(GL_TEXTURE_BINDING_2D, &previous_binding);
  glGetIntegerv(GL_PACK_ALIGNMENT, &alignment);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glBindTexture(GL_TEXTURE_2D, texture);
  glGetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_WIDTH, &width);
  glGetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_HEIGHT, &height);
  const std::size_t row = 3 * static_cast<std::size_t>(width);
  std::vector<char> rgb(row * static_cast<std::size_t>(height));
  glGetTexImage(GL_TEXTURE_2D, 0, GL_RGB, GL_UNSIGNED_BYTE, rgb.data());
  glBindTexture(GL_TEXTURE_2D, static_cast<GLuint>(previous_binding));
  glPixelStorei(GL_PACK_ALIGNMENT, alignment);
  std::ofstream file(name, std::ios::binary);
  file << "P6 " << width << ' ' << height << " 255\n";
  for (int y = height - 1; y >= 0; --y) file.write(&rgb[row * static_cast<std::size_t>(y)], static_cast<std::streamsize>(row));
}

bool is_view_as_located(const XrCompositionLayerProjectionView& layer_view, const XrView& view, int eye) {
  const XrRect2Di& part = layer_view.subImage.imageRect;
  return std::memcmp(&layer_view.pose, &view.pose, sizeof view.pose) == 0 &&
         std::memcmp(&layer_view.fov, &view.fov, sizeof view.fov) == 0 && part.offset.x == 0 && part.offset.y == 0 &&
         part.extent.width == g_mock.number("width", 320) && part.extent.height == g_mock.number("height", 352) &&
         layer_view.subImage.swapchain == handle<XrSwapchain>(3 + eye);
}

XrResult end_frame(XrSession, const XrFrameEndInfo* info) {
  MOCK_RETURN_IF_LOST("xrEndFrame");
  if (!g_mock.is_frame_begun) return g_mock.wrong("xrEndFrame");
  g_mock.is_frame_awaited = g_mock.is_frame_begun = false;
  const int frame = g_mock.frames - 1;
  if (info->displayTime != mock_xr::kFirstFrameNs + frame * mock_xr::kPeriodNs) return XR_ERROR_TIME_INVALID;
  g_mock.log(fmt::format("frame {} layers {}", frame, info->layerCount));
  if (info->layerCount == 1) {
    const auto* layer = reinterpret_cast<const XrCompositionLayerProjection*>(info->layers[0]);
    if (layer->type != XR_TYPE_COMPOSITION_LAYER_PROJECTION || layer->viewCount != 2) return XR_ERROR_LAYER_INVALID;
    const auto views = views_at(frame);
    for (int eye = 0; eye < 2; ++eye) {
      const Chain& chain = g_mock.chains[static_cast<std::size_t>(eye)];
      if (!is_view_as_located(layer->views[eye], views[static_cast<std::size_t>(eye)], eye) || chain.shown < 0)
        g_mock.log("wrong: a view of the layer");
      if (!g_mock.has("out") || chain.shown < 0) continue;
      write_picture(fmt::format("{}/frame_{:03}_{}.ppm", g_mock.words.at("out"), frame, eye),
                    chain.textures[static_cast<std::size_t>(chain.shown)]);
    }
  }
  if (g_mock.frames == g_mock.number("exit_after", 1 << 30)) g_mock.enter(XR_SESSION_STATE_STOPPING);
  if (g_mock.frames == g_mock.number("stop_after", 1 << 30)) kill(getpid(), SIGINT);
  if (g_mock.frames == g_mock.number("pending_after", 1 << 30)) g_mock.enter(XR_SESSION_STATE_LOSS_PENDING);
  return XR_SUCCESS;
}

XrResult get_proc(XrInstance, const char* name, PFN_xrVoidFunction* found) {
#define MOCK_CALL(name, function) \
  { name, reinterpret_cast<PFN_xrVoidFunction>(&(function)) }
  static const std::map<std::string, PFN_xrVoidFunction> kCalls = {
      MOCK_CALL("xrGetInstanceProcAddr", get_proc),
      MOCK_CALL("xrEnumerateInstanceExtensionProperties", enumerate_extensions),
      MOCK_CALL("xrCreateInstance", create_instance),
      MOCK_CALL("xrDestroyInstance", destroy_instance),
      MOCK_CALL("xrGetInstanceProperties", instance_properties),
      MOCK_CALL("xrGetSystem", get_system),
      MOCK_CALL("xrEnumerateViewConfigurationViews", configuration_views),
      MOCK_CALL("xrEnumerateEnvironmentBlendModes", blend_modes),
      MOCK_CALL("xrGetOpenGLGraphicsRequirementsKHR", opengl_requirements),
      MOCK_CALL("xrCreateSession", create_session),
      MOCK_CALL("xrDestroySession", destroy_session),
      MOCK_CALL("xrCreateReferenceSpace", create_space),
      MOCK_CALL("xrDestroySpace", destroy_space),
      MOCK_CALL("xrEnumerateSwapchainFormats", formats),
      MOCK_CALL("xrCreateSwapchain", create_chain),
      MOCK_CALL("xrDestroySwapchain", destroy_chain),
      MOCK_CALL("xrEnumerateSwapchainImages", chain_images),
      MOCK_CALL("xrAcquireSwapchainImage", acquire),
      MOCK_CALL("xrWaitSwapchainImage", wait_image),
      MOCK_CALL("xrReleaseSwapchainImage", release),
      MOCK_CALL("xrPollEvent", poll_event),
      MOCK_CALL("xrBeginSession", begin_session),
      MOCK_CALL("xrEndSession", end_session),
      MOCK_CALL("xrRequestExitSession", request_exit),
      MOCK_CALL("xrWaitFrame", wait_frame),
      MOCK_CALL("xrBeginFrame", begin_frame),
      MOCK_CALL("xrLocateViews", locate_views),
      MOCK_CALL("xrEndFrame", end_frame)};
  const auto known = kCalls.find(name);
  *found = known != kCalls.end() ? known->second : nullptr;
  return known != kCalls.end() ? XR_SUCCESS : XR_ERROR_FUNCTION_UNSUPPORTED;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) XrResult xrNegotiateLoaderRuntimeInterface(const XrNegotiateLoaderInfo*,
                                                                                             XrNegotiateRuntimeRequest* request) {
  request->runtimeInterfaceVersion = 1;
  request->runtimeApiVersion = XR_MAKE_VERSION(1, 0, 20);
  request->getInstanceProcAddr = get_proc;
  return XR_SUCCESS;
}
