#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <GL/glew.h>

#include "scene/mesh_appearance.h"

namespace hapton {

// The images of a mesh on the graphics side, one layer each, all of one size, so that a mesh of many images is still drawn at once. An
// image repeats beyond its edges. Threads: the window's; its context is current, at the end as well.
class TextureLayers {
 public:
  // Of the images that the look's materials use. Those that cannot be decoded have no layer; notes says why. Null: there are none.
  static std::unique_ptr<TextureLayers> make(const MeshAppearance& appearance, std::vector<std::string>& notes);
  ~TextureLayers();
  TextureLayers(const TextureLayers&) = delete;
  TextureLayers& operator=(const TextureLayers&) = delete;

  // Of each image of the look; from 1, 0: none.
  const std::vector<std::uint8_t>& layer_of() const { return layer_of_; }
  // For the next drawing, in the active texture unit. unit(): its number.
  void bind() const;
  static void unbind();
  static int unit();

 private:
  TextureLayers() = default;
  GLuint texture_ = 0;
  std::vector<std::uint8_t> layer_of_;
};

// The layers of a scene's objects: those whose materials use the same images share them, as instances and parts of one file do. Threads: as
// TextureLayers.
class SharedTextures {
 public:
  // As TextureLayers::make; notes: the first time only. Pre: not null.
  std::shared_ptr<const TextureLayers> make(std::shared_ptr<const MeshAppearance> appearance, std::vector<std::string>& notes);

 private:
  struct Made {
    std::shared_ptr<const MeshAppearance> appearance;
    std::shared_ptr<const TextureLayers> layers;
  };
  std::vector<Made> made_;
};

}  // namespace hapton
