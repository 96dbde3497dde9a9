#include "devices/vendor_library.h"

#include <dlfcn.h>
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <array>
#include <cstdlib>
#include <filesystem>

namespace hapton {
namespace {

constexpr std::array<std::string_view, 5> kOpenHapticsFiles = {"libHD.so", "libHD.so.3.4", "libHD.so.3", "libHD.so.3.5", "libHD.so.3.0"};
constexpr std::array<std::string_view, 1> kOpenHapticsVariables = {"GTDD_HOME"};
// libdrd first: it contains all of libdhd, and can calibrate.
constexpr std::array<std::string_view, 4> kForceDimensionFiles = {"libdrd.so", "libdrd.so.3", "libdhd.so", "libdhd.so.3"};
constexpr std::array<std::string_view, 1> kForceDimensionVariables = {"FORCEDIM_SDK"};

// Dependencies that Debian 12 lacks, and what provides each of them.
struct KnownDependency {
  std::string_view file;
  std::string_view remedy;
};
constexpr std::array<KnownDependency, 6> kKnownDependencies = {{
    {"libncurses.so.5", "install libncurses5 (apt-get install libncurses5)"},
    {"libtinfo.so.5", "install libtinfo5 (apt-get install libtinfo5)"},
    {"libraw1394.so", "install libraw1394-11 (apt-get install libraw1394-11)"},
    {"libPhantomIOLib42", "install the Touch device driver of 3D Systems, which brings it"},
    {"libPHANToMIO", "install the PHANToM device driver of the same OpenHaptics release, which brings it"},
    {"libusb-1.0.so", "install libusb-1.0-0 (apt-get install libusb-1.0-0)"},
}};

std::string_view remedy_for_dependency(std::string_view dependency) {
  for (const KnownDependency& known : kKnownDependencies) {
    if (dependency.starts_with(known.file)) return known.remedy;
  }
  return "install the package that has it, or put its folder into LD_LIBRARY_PATH";
}

bool has(std::string_view text, std::string_view part) { return text.find(part) != std::string_view::npos; }

std::string_view last_name(std::string_view path) { return path.substr(path.find_last_of('/') + 1); }

}  // namespace

const KnownVendorLibrary kOpenHaptics = {"OpenHaptics",
                                         "openhaptics",
                                         kOpenHapticsFiles,
                                         "3D Systems / SensAble PHANToM Premium, Desktop and Omni, Touch, Touch X, Touch HID",
                                         "OpenHaptics for Linux (Developer Edition) and the Touch device driver, both from 3D Systems",
                                         kOpenHapticsVariables};

const KnownVendorLibrary kForceDimension = {
    "Force Dimension SDK",
    "forcedimension",
    kForceDimensionFiles,
    "Force Dimension omega.x, delta.x, sigma.7, lambda.7; Novint Falcon",
    "the Force Dimension SDK for Linux from forcedimension.com; its lib folder into LD_LIBRARY_PATH",
    kForceDimensionVariables};

std::span<const KnownVendorLibrary> known_vendor_libraries() {
  static const std::array<KnownVendorLibrary, 2> all = {kOpenHaptics, kForceDimension};
  return all;
}

std::string hint_for_load_error(std::string_view file, std::string_view error) {
  const std::string_view missing = error.substr(0, error.find(':'));
  if (has(error, "No such file or directory")) {
    if (missing == file) {
      return file.find('/') == std::string_view::npos
                 ? "it is not in the loader's folders; install it, or put its folder into LD_LIBRARY_PATH"
                 : "there is no such file";
    }
    return fmt::format("{} exists, but needs {}, which is missing: {}", last_name(file), missing, remedy_for_dependency(missing));
  }
  if (has(error, "wrong ELF class") || has(error, "invalid ELF header") || has(error, "file too short"))
    return "it is not a library for this machine; get the 64-bit one for Linux";
  if (has(error, "version `")) return "it was built for a newer system than this; get the one for this release, or a newer system";
  if (has(error, "undefined symbol")) return "it and the libraries it needs are of different releases; install all from one";
  if (has(error, "executable stack")) return "the kernel forbids it an executable stack; clear the mark with: execstack -c FILE";
  if (has(error, "Permission denied")) return "it is not readable; chmod a+r the file";
  return "the line above is the loader's; `ldd FILE` says more";
}

VendorLibrary VendorLibrary::try_open(const KnownVendorLibrary& vendor, const std::string& file, std::vector<FailedLoad>& failures) {
  VendorLibrary library;
  std::vector<std::string> names(vendor.file_names.begin(), vendor.file_names.end());
  if (!file.empty()) names = {file};
  for (const std::string& name : names) {
    // Binds all symbols now: a missing one is reported here instead of ending the program at its first call.
    library.handle_ = ::dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (library.handle_ != nullptr) {
      library.file_ = name;
      return library;
    }
    const char* message = ::dlerror();
    const std::string error = message != nullptr ? message : "the loader gave no reason";
    failures.push_back({name, error, hint_for_load_error(name, error)});
  }
  return library;
}

Result<VendorLibrary> VendorLibrary::open(const KnownVendorLibrary& vendor, const std::string& file) {
  std::vector<FailedLoad> failures;
  VendorLibrary library = try_open(vendor, file, failures);
  if (!library.file_.empty()) return library;
  // The error of a file that exists but does not load says more than that of a missing file.
  const FailedLoad* clearest = &failures.front();
  std::vector<std::string> errors;
  for (const FailedLoad& failure : failures) {
    errors.push_back(failure.error);
    if (!failure.error.starts_with(failure.file + ": cannot open") && clearest == &failures.front()) clearest = &failure;
  }
  return fail("{} cannot be loaded ({}); {}. It comes with {}", vendor.name, fmt::join(errors, "; "), clearest->hint, vendor.source);
}

void* VendorLibrary::address_of(const char* symbol) const noexcept { return ::dlsym(handle_, symbol); }

Error missing_symbols(const VendorLibrary& library, std::span<const std::string_view> missing) {
  return Error{fmt::format("{} has no {}; it is of a release that io_node does not know: install a newer one", library.file(),
                           fmt::join(missing, ", "))};
}

}  // namespace hapton
