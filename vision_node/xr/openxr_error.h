#pragma once

#include <string>
#include <string_view>

#include <openxr/openxr.h>

#include "core/base/result.h"

namespace hapton {

// OpenXR's own name of a result, as a person finds it on the web; a number for results of extensions that we do not ask for.
std::string openxr_name(XrResult result);

// Why the headset cannot be used, in one line; call: what was tried. Pre: XR_FAILED(result), or what was tried is not there.
Error explain_openxr(XrResult result, std::string_view call);

}  // namespace hapton
