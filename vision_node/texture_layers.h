#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <GL/glew.h>

#include "scene/mesh_appearance.h"

namespace hapton {

// The images of a mesh as the layers of one OpenGL texture, all of the same size, so that a mesh with many images is still drawn at once.
// Beyond its edges an image repeats. Threads: the window's, with its context current, also in the destructor.
class TextureLayers {
 public:
  // One layer for each image that the materials use, at most 255. An image that cannot be decoded has none; notes says why. Null: no layer.
  static std::unique_ptr<TextureLayers> make(const MeshAppearance& appearance, std::vector<std::string>& notes);
  ~TextureLayers();
  TextureLayers(const TextureLayers&) = delete;
  TextureLayers& operator=(const TextureLayers&) = delete;

  // The layer of each image of the appearance, from 1; 0: none.
  const std::vector<std::uint8_t>& layer_of() const { return layer_of_; }
  // Binds the texture to the active texture unit, for what is drawn next. unit(): the number of that unit.
  void bind() const;
  static void unbind();
  static int unit();

 private:
  TextureLayers() = default;
  GLuint texture_ = 0;
  std::vector<std::uint8_t> layer_of_;
};

// The layers of a scene's objects. Objects whose materials use the same images share their layers, as instances and parts of one file do.
// Threads: see TextureLayers.
class SharedTextures {
 public:
  // See TextureLayers::make; notes: nothing is added for layers that exist already. Pre: appearance is not null.
  std::shared_ptr<const TextureLayers> make(std::shared_ptr<const MeshAppearance> appearance, std::vector<std::string>& notes);

 private:
  struct SharedLayers {
    std::shared_ptr<const MeshAppearance> appearance;
    std::shared_ptr<const TextureLayers> layers;
  };
  std::vector<SharedLayers> shared_layers_;
};

}  // namespace hapton
