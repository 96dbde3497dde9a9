#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "scene/gltf/json.h"

namespace hapton::gltf {

// The bytes of a document's buffers, read on first use: a missing buffer that only textures use is not an error.
class Buffers {
 public:
  // root: the document, which must outlive this object. binary: a GLB's second chunk. folder: base of relative URIs.
  Buffers(const Json& root, std::optional<std::string_view> binary, const std::filesystem::path& folder)
      : root_(root), binary_(binary), folder_(folder), bytes_read_(binary ? binary->size() : 0) {}

  struct View {
    std::string_view bytes;  // valid as long as the Buffers exist
    std::size_t stride = 0;  // 0: tightly packed
  };
  // A buffer view [3.6.1]; one with EXT_meshopt_compression is decompressed.
  Result<View> view(const Json& index_json, const std::string& where);

  // A copy of the bytes of a buffer view for an image. Error: all images together exceed kMaxCopyRatio times the bytes of all buffers.
  Result<std::string> copy_for_image(const Json& index_json, const std::string& where);

  // Size of all buffers read so far, before decompression.
  std::size_t bytes_read() const { return bytes_read_; }

 private:
  // Any number of images may share a view, so only this bounds their copies by the size of the file.
  static constexpr std::size_t kMaxCopyRatio = 8;

  Result<View> compressed_view(std::size_t index, const Json& compression);
  Result<std::string_view> range(const Json& json, const std::string& name);
  Result<std::string_view> buffer(const Json& index_json, const std::string& where);
  Result<std::string> load_buffer(const std::string& uri, const std::string& name) const;

  const Json& root_;
  std::optional<std::string_view> binary_;
  std::filesystem::path folder_;
  std::map<std::string, std::string> loaded_;    // bytes of each buffer that is not in the GLB, by file, or by its name if it is inline
  std::map<std::size_t, std::string> unfolded_;  // decompressed bytes, by buffer view
  std::size_t bytes_read_;
  std::size_t unfolded_bytes_ = 0;  // of all buffer views in unfolded_
  std::size_t copied_bytes_ = 0;    // bytes that were copied for images
};

}  // namespace hapton::gltf
