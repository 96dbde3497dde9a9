#pragma once

#include <string>
#include <string_view>

#include <openxr/openxr.h>

#include "core/base/result.h"

namespace hapton {

// The name of a common error in OpenXR, for the log ("XR_ERROR_RUNTIME_FAILURE"); "XrResult N" for any other result.
std::string openxr_name(XrResult result);

// Says why the headset cannot be used, in one line, with a remedy. call: the OpenXR call, or what was requested. Pre: XR_FAILED(result), or
// the runtime lacks what was requested.
Error explain_openxr(XrResult result, std::string_view call);

}  // namespace hapton
