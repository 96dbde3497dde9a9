#pragma once

#include <cstddef>
#include <cstdint>

#include <openxr/openxr.h>

// Structures of the interface between OpenXR loader and runtime (OpenXR 1.0, "Loader and runtime negotiation"), for which Debian's
// libopenxr-dev has no header.
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
