#include "vision_node/xr/openxr_error.h"

#include <cstdlib>

#include <fmt/format.h>

namespace hapton {
namespace {

Error explain_missing(XrResult result) {
  if (const char* named = std::getenv("XR_RUNTIME_JSON"); named != nullptr && *named != '\0') {
    return {fmt::format(
        "--stereo openxr: the OpenXR runtime of XR_RUNTIME_JSON={} cannot be loaded ({}); give the .json file of an installed one", named,
        openxr_name(result))};
  }
  return {
      "--stereo openxr: no OpenXR runtime is active on this machine; install one (Monado, SteamVR) and make it the active one, or name its "
      ".json file in XR_RUNTIME_JSON"};
}

}  // namespace

std::string openxr_name(XrResult result) {
  switch (result) {
#define HAPTON_XR_NAME(name) \
  case name:                 \
    return #name;
    HAPTON_XR_NAME(XR_ERROR_VALIDATION_FAILURE)
    HAPTON_XR_NAME(XR_ERROR_RUNTIME_FAILURE)
    HAPTON_XR_NAME(XR_ERROR_OUT_OF_MEMORY)
    HAPTON_XR_NAME(XR_ERROR_API_VERSION_UNSUPPORTED)
    HAPTON_XR_NAME(XR_ERROR_INITIALIZATION_FAILED)
    HAPTON_XR_NAME(XR_ERROR_FUNCTION_UNSUPPORTED)
    HAPTON_XR_NAME(XR_ERROR_EXTENSION_NOT_PRESENT)
    HAPTON_XR_NAME(XR_ERROR_LIMIT_REACHED)
    HAPTON_XR_NAME(XR_ERROR_HANDLE_INVALID)
    HAPTON_XR_NAME(XR_ERROR_INSTANCE_LOST)
    HAPTON_XR_NAME(XR_ERROR_SESSION_LOST)
    HAPTON_XR_NAME(XR_ERROR_SESSION_NOT_RUNNING)
    HAPTON_XR_NAME(XR_ERROR_FORM_FACTOR_UNSUPPORTED)
    HAPTON_XR_NAME(XR_ERROR_FORM_FACTOR_UNAVAILABLE)
    HAPTON_XR_NAME(XR_ERROR_FILE_ACCESS_ERROR)
    HAPTON_XR_NAME(XR_ERROR_FILE_CONTENTS_INVALID)
    HAPTON_XR_NAME(XR_ERROR_GRAPHICS_DEVICE_INVALID)
    HAPTON_XR_NAME(XR_ERROR_RUNTIME_UNAVAILABLE)
#undef HAPTON_XR_NAME
    default:
      return fmt::format("XrResult {}", static_cast<int>(result));
  }
}

Error explain_openxr(XrResult result, std::string_view call) {
  switch (result) {
    case XR_ERROR_RUNTIME_UNAVAILABLE:
    case XR_ERROR_FILE_ACCESS_ERROR:
    case XR_ERROR_FILE_CONTENTS_INVALID:
      return explain_missing(result);
    case XR_ERROR_FORM_FACTOR_UNAVAILABLE:
      return {"--stereo openxr: the OpenXR runtime finds no headset; connect it, switch it on, and start again"};
    case XR_ERROR_FORM_FACTOR_UNSUPPORTED:
      return {"--stereo openxr: the OpenXR runtime knows no headsets; make another runtime the active one"};
    default:
      return {fmt::format("--stereo openxr: the OpenXR runtime rejected {} ({}); its own log says why", call, openxr_name(result))};
  }
}

}  // namespace hapton
