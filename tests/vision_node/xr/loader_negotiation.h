#pragma once

#include <cstddef>
#include <cstdint>

#include <openxr/openxr.h>

// Of the interface between loader and runtime, which Debian's libopenxr-dev does not have as a header (OpenXR 1.0, "Loader and runtime
// negotiation").
extern "C" {
struct XrNegotiateLoaderInfo {
  int structType;
  uint32_t structVersion;
  size_t structSize;
  uint32_t minInterfaceVersion;
  uint32_t maxInterfaceVersion;
  XrVersion minApiVersion;
  XrVersion maxApiVersion;
};
struct XrNegotiateRuntimeRequest {
  int structType;
  uint32_t structVersion;
  size_t structSize;
  uint32_t runtimeInterfaceVersion;
  XrVersion runtimeApiVersion;
  PFN_xrGetInstanceProcAddr getInstanceProcAddr;
};
}
