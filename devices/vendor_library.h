#pragma once

#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/base/result.h"

namespace hapton {

// A vendor's library that Hapton can use where it is installed. We declare its functions ourselves, so that building needs nothing of it.
struct KnownVendorLibrary {
  std::string_view name;                          // for people: "OpenHaptics"
  std::string_view device;                        // the name for --device
  std::span<const std::string_view> file_names;   // in the order in which they are tried
  std::string_view devices;                       // the devices that it drives, for people
  std::string_view source;                        // where a person gets it, with what else is needed
  std::span<const std::string_view> environment;  // variables that it reads, or that its users set
};

// All vendor libraries that Hapton can use. RT: set-up only.
std::span<const KnownVendorLibrary> known_vendor_libraries();
extern const KnownVendorLibrary kOpenHaptics;
extern const KnownVendorLibrary kForceDimension;

// One name that was tried and did not load.
struct FailedLoad {
  std::string file;
  std::string error;  // the loader's words, unchanged
  std::string hint;   // what a person can do about it, one line; never empty
};

// What the loader's words mean for `file`: which dependency is missing, and so on.
std::string hint_for_load_error(std::string_view file, std::string_view error);

// A library of a vendor, loaded at run time. It stays loaded until the process ends, whatever becomes of this object: such libraries leave
// threads behind.
// RT: set-up only. Threads: any.
class VendorLibrary {
 public:
  // Loads the first of the library's names that can be loaded; with `file` only that (a path, or a name for the loader to look up).
  // Error: one line with the loader's own words for every name, and the hint that helps most.
  static Result<VendorLibrary> open(const KnownVendorLibrary& known, const std::string& file = "");

  // The same, and adds each name that did not load to `failures`. If none loads, file() of the result is empty.
  static VendorLibrary try_open(const KnownVendorLibrary& known, const std::string& file, std::vector<FailedLoad>& failures);

  // The name or path with which it was loaded, as given to the loader.
  const std::string& file() const { return file_; }

  // Function: the type of the function, `find<int(double)>("f")`. Null when the library has no such symbol.
  template <class Function>
  Function* find(const char* symbol) const noexcept {
    static_assert(std::is_function_v<Function>);
    return reinterpret_cast<Function*>(address_of(symbol));
  }

  // Sets `into` to the function of that name, or to null; then the name is added to `missing`.
  template <class Function>
  void require(const char* symbol, Function*& into, std::vector<std::string_view>& missing) const {
    into = find<Function>(symbol);
    if (into == nullptr) missing.emplace_back(symbol);
  }

 private:
  void* address_of(const char* symbol) const noexcept;

  void* handle_ = nullptr;
  std::string file_;
};

// "libHD.so has no hdFoo, hdBar: ..." Pre: missing is not empty.
Error missing_symbols(const VendorLibrary& library, std::span<const std::string_view> missing);

}  // namespace hapton
