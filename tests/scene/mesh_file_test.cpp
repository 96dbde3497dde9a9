#include "scene/mesh_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "tests/scene/sample_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

struct Sample {
  std::string name;
  std::string bytes;
  bool is_valid_if_cut;  // OBJ and the like: a cut between lines leaves a valid, shorter file
};

std::vector<Sample> samples() {
  const TriangleMesh mesh = sample::tetrahedron();
  return {{"a.obj", sample::obj(mesh), true},
          {"ascii.stl", sample::ascii_stl(mesh), false},
          {"binary.stl", sample::binary_stl(mesh), false},
          {"solid.stl", sample::binary_stl(mesh, "solid that lies: it is binary"), false},
          {"ascii.ply", sample::ascii_ply(mesh), false},
          {"little.ply", sample::binary_ply(mesh), false},
          {"big.ply", sample::binary_ply(mesh, true), false},
          {"inline.gltf", sample::inline_gltf(mesh), false},
          {"a.glb", sample::glb(sample::gltf_json(mesh, ""), sample::gltf_buffer(mesh)), false}};
}

void expect_valid_mesh(const TriangleMesh& mesh) {
  EXPECT_FALSE(mesh.triangles.empty());
  for (const Vec3& v : mesh.vertices) EXPECT_TRUE(v.allFinite());
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) EXPECT_LT(v, mesh.vertices.size());
  }
}

// The error is one line of plain text that begins with the path of the file.
void expect_clear_error(const Error& error, const std::filesystem::path& path) {
  EXPECT_THAT(error.what, StartsWith(path.string() + ": "));
  EXPECT_EQ(error.what.find('\n'), std::string::npos) << error.what;
  for (const char c : error.what) EXPECT_TRUE(c >= ' ' && c <= '~') << error.what;
  EXPECT_LT(error.what.size(), path.string().size() + 400) << error.what;
}

std::string error_of(const std::filesystem::path& path, std::optional<Unit> unit = std::nullopt) {
  const auto file = load_mesh_file(path, unit);
  if (file) return "it was read";
  expect_clear_error(file.error(), path);
  return file.error().what;
}

TEST(MeshFile, GivesTheSameMeshFromEveryFormat) {
  const ScratchFolder folder;
  const TriangleMesh expected = sample::tetrahedron();
  for (const Sample& sample : samples()) {
    const auto file = load_mesh_file(folder.write(sample.name, sample.bytes));
    ASSERT_TRUE(file) << file.error().what;
    EXPECT_THAT(file->notes, IsEmpty()) << sample.name;
    ASSERT_EQ(file->mesh.triangles.size(), expected.triangles.size()) << sample.name;
    EXPECT_EQ(file->mesh.vertices.size(), expected.vertices.size()) << sample.name;
    for (std::size_t t = 0; t < expected.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) EXPECT_EQ(file->mesh.corner(t, k), expected.corner(t, k)) << sample.name;
    }
    ASSERT_EQ(file->parts.size(), 1U) << sample.name;
    EXPECT_EQ(file->parts[0].triangle_count, expected.triangles.size()) << sample.name;
  }
}

TEST(MeshFile, ScalesToMetres) {
  const ScratchFolder folder;
  const auto path = folder.write("a.obj", sample::obj(sample::tetrahedron()));
  for (const auto& [unit, metres] : {std::pair(Unit::m, 1.0), {Unit::cm, 0.01}, {Unit::mm, 0.001}, {Unit::in, 0.0254}}) {
    const auto file = load_mesh_file(path, unit);
    ASSERT_TRUE(file) << file.error().what;
    EXPECT_DOUBLE_EQ(file->mesh.corner(0, 1).x(), 1.5 * metres);
    EXPECT_EQ(file->unit, unit);
  }
}

TEST(MeshFile, GltfIsInMetresOnly) {
  const ScratchFolder folder;
  const auto path = folder.write("a.gltf", sample::inline_gltf(sample::tetrahedron()));
  EXPECT_TRUE(load_mesh_file(path, Unit::m));
  EXPECT_THAT(error_of(path, Unit::mm), HasSubstr("always in metres"));
}

TEST(MeshFile, SaysThatASizeLooksWrongOnlyWhenNoUnitWasGiven) {
  const ScratchFolder folder;
  const auto path = folder.write("a.obj", "v 0 0 0\nv 1800 0 0\nv 0 900 0\nf 1 2 3\n");
  const auto guessed = load_mesh_file(path);
  ASSERT_TRUE(guessed);
  ASSERT_EQ(guessed->notes.size(), 1U);
  EXPECT_THAT(guessed->notes[0], AllOf(HasSubstr("1800 m"), HasSubstr("unit")));
  EXPECT_THAT(load_mesh_file(path, Unit::mm)->notes, IsEmpty());
}

TEST(MeshFile, ReadsABufferBesideTheFileAndUnescapesItsName) {
  const ScratchFolder folder;
  const TriangleMesh mesh = sample::tetrahedron();
  folder.write("the mesh.bin", sample::gltf_buffer(mesh));
  const auto file = load_mesh_file(folder.write("a.gltf", sample::gltf_json(mesh, R"("uri":"the%20mesh.bin",)")));
  ASSERT_TRUE(file) << file.error().what;
  EXPECT_EQ(file->mesh.triangles.size(), 4U);
}

TEST(MeshFile, RejectsWhatIsNoFile) {
  const ScratchFolder folder;
  EXPECT_THAT(error_of(folder.path() / "none.obj"), HasSubstr("no such file"));
  std::filesystem::create_directory(folder.path() / "a.stl");
  EXPECT_THAT(error_of(folder.path() / "a.stl"), HasSubstr("is a folder"));
  EXPECT_THAT(error_of(folder.write("empty.ply", "")), HasSubstr("empty"));
  EXPECT_THAT(error_of(folder.write("a.step", "ISO-10303-21;")), HasSubstr("unknown mesh extension '.step'"));
  ASSERT_EQ(mkfifo((folder.path() / "pipe.obj").c_str(), 0600), 0);
  EXPECT_THAT(error_of(folder.path() / "pipe.obj"), HasSubstr("not a regular file"));
}

TEST(MeshFile, RejectsAMeshWithoutTriangles) {
  const ScratchFolder folder;
  EXPECT_THAT(error_of(folder.write("a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n")), HasSubstr("no triangles"));
  EXPECT_THAT(error_of(folder.write("a.stl", sample::binary_stl({}))), HasSubstr("no triangles"));
  EXPECT_THAT(error_of(folder.write("b.stl", "solid a\nendsolid a\n")), HasSubstr("no triangles"));
  EXPECT_THAT(error_of(folder.write("a.ply", sample::ply_header("ascii", 0, 0))), HasSubstr("no triangles"));
  EXPECT_THAT(error_of(folder.write("a.gltf", R"({"asset":{"version":"2.0"}})")), HasSubstr("no triangles"));
}

TEST(MeshFile, RejectsCoordinatesBeyondAllMeaning) {
  const ScratchFolder folder;
  EXPECT_THAT(error_of(folder.write("a.obj", "v 0 0 0\nv 1e200 0 0\nv 0 1 0\nf 1 2 3\n")), HasSubstr("beyond 1e+12 m"));
}

TEST(MeshFile, DoesNotBelieveCounts) {
  const ScratchFolder folder;
  std::string ply = sample::ascii_ply(sample::tetrahedron());
  ply.replace(ply.find("vertex 4"), 8, "vertex 4000000000");
  EXPECT_THAT(error_of(folder.write("v.ply", ply)), HasSubstr("promises 4000000000 of 'vertex'"));
  ply = sample::binary_ply(sample::tetrahedron());
  ply.replace(ply.find("face 4"), 6, "face 4000000000");
  EXPECT_THAT(error_of(folder.write("f.ply", ply)), HasSubstr("promises 4000000000 of 'face'"));
  std::string stl = sample::binary_stl(sample::tetrahedron());
  const std::uint32_t count = 4000000000U;
  std::memcpy(stl.data() + 80, &count, sizeof count);
  EXPECT_THAT(error_of(folder.write("a.stl", stl)), HasSubstr("promises 4000000000 triangles"));
  std::string gltf = sample::inline_gltf(sample::tetrahedron());
  gltf.replace(gltf.find("\"count\":4"), 9, "\"count\":4000000000");
  EXPECT_THAT(error_of(folder.write("a.gltf", gltf)), HasSubstr("promises 4000000000 items"));
}

// A file cut anywhere gives an error of one line; if the format cannot show the cut (such as OBJ after a line), the rest is read.
TEST(MeshFile, ReadsNoFileThatWasCutShort) {
  const ScratchFolder folder;
  for (const Sample& sample : samples()) {
    const std::size_t last = sample.bytes.find_last_not_of(" \n");
    for (std::size_t size = 0; size < sample.bytes.size(); ++size) {
      const std::string cut = sample.bytes.substr(0, size);
      const auto path = folder.write(sample.name, cut);
      const auto file = load_mesh_file(path);
      if (!file) {
        expect_clear_error(file.error(), path);
        continue;
      }
      expect_valid_mesh(file->mesh);
      const bool only_blanks_gone = size > last;
      const bool noted = !file->notes.empty() && file->notes.back().find("cut short") != std::string::npos;
      const bool ends_a_line = cut.ends_with('\n');
      const bool last_number_shorter = sample.name == "ascii.ply" && size == last;  // "3 2 3 10" cut to "3 2 3 1"
      const bool only_name_gone = sample.name == "ascii.stl" && size >= sample.bytes.find("endsolid") + 8;
      EXPECT_TRUE(only_blanks_gone || (sample.is_valid_if_cut && (noted || ends_a_line)) || (last_number_shorter && noted) ||
                  only_name_gone)
          << sample.name << " cut to " << size << " of " << sample.bytes.size();
    }
  }
}

TEST(MeshFile, NotesVerticesOfAnObjFileThatBelongToNoFace) {
  const ScratchFolder folder;
  const std::string whole = sample::obj(sample::tetrahedron());
  EXPECT_THAT(load_mesh_file(folder.write("whole.obj", whole))->notes, IsEmpty());
  // One face is left of four.
  const std::size_t second_face = whole.find("\nf", whole.find("\nf") + 1) + 1;
  const auto cut = load_mesh_file(folder.write("cut.obj", whole.substr(0, second_face)));
  ASSERT_TRUE(cut) << cut.error().what;
  ASSERT_EQ(cut->mesh.triangles.size(), 1U);
  ASSERT_EQ(cut->notes.size(), 1U);
  EXPECT_EQ(cut->notes[0], "1 of 4 vertices belong to no face: the file may have been cut short");
}

TEST(MeshFile, SaysWhenABufferWasCutShort) {
  const ScratchFolder folder;
  const TriangleMesh mesh = sample::tetrahedron();
  const auto path = folder.write("a.gltf", sample::gltf_json(mesh, R"("uri":"a.bin",)"));
  EXPECT_THAT(error_of(path), AllOf(HasSubstr("a.bin"), HasSubstr("no such file")));
  const std::string buffer = sample::gltf_buffer(mesh);
  for (std::size_t size = 1; size < buffer.size(); ++size) {
    folder.write("a.bin", buffer.substr(0, size));
    EXPECT_THAT(error_of(path), HasSubstr(fmt::format("should have {} bytes but has {}", buffer.size(), size)));
  }
}

// Bytes changed at random: never a crash, a hang or an unsound mesh.
TEST(MeshFile, SurvivesDamage) {
  const unsigned seed = 20260807;
  RecordProperty("seed", static_cast<int>(seed));
  std::mt19937 random(seed);
  const ScratchFolder folder;
  int read_count = 0;
  int rejected_count = 0;
  for (const Sample& sample : samples()) {
    for (int round = 0; round < 1500; ++round) {
      std::string damaged = sample.bytes;
      const auto change_count = 1 + random() % 4;
      for (unsigned k = 0; k < change_count; ++k) {
        const std::size_t at = random() % damaged.size();
        switch (random() % 4) {
          case 0:
            damaged[at] = static_cast<char>(random());
            break;
          case 1:
            damaged[at] = "0123456789-.eE[]{},:\"\n "[random() % 23];
            break;
          case 2:
            damaged.erase(at, 1 + random() % 8);
            break;
          default:
            damaged.insert(at, damaged.substr(random() % damaged.size(), random() % 16));
            break;
        }
        if (damaged.empty()) damaged = "x";
      }
      const auto path = folder.write(sample.name, damaged);
      const auto file = load_mesh_file(path);
      ++(file ? read_count : rejected_count);
      if (file)
        expect_valid_mesh(file->mesh);
      else
        expect_clear_error(file.error(), path);
    }
  }
  EXPECT_GT(read_count, 100);
  EXPECT_GT(rejected_count, 100);
}

TEST(MeshFile, GivesAPartByItsName) {
  const auto file = load_mesh_file(HAPTON_SOURCE_DIR "/meshes/nist_assembly_insert.obj");
  ASSERT_TRUE(file) << file.error().what;
  std::size_t triangle_count = 0;
  for (const char* name : {"insert_base", "mounts", "pipe_1", "pipe_2", "hardware", "screen"}) {
    const auto part = extract_part(*file, name);
    ASSERT_TRUE(part) << part.error().what;
    expect_valid_mesh(*part);
    EXPECT_LT(part->vertices.size(), file->mesh.vertices.size());
    triangle_count += part->triangles.size();
  }
  EXPECT_EQ(triangle_count, 7216U);
  const auto none = extract_part(*file, "pipe_3");
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().what, AllOf(HasSubstr("'pipe_3'"), HasSubstr("'pipe_1'")));
}

// A part name may contain control sequences, which a terminal would execute.
TEST(MeshFile, ShowsOnlyThePrintableCharactersOfPartNames) {
  const ScratchFolder folder;
  const auto file = load_mesh_file(folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\ng red\x1b[31m\nf 1 2 3\n"));
  ASSERT_TRUE(file) << file.error().what;
  const auto none = extract_part(*file, "blue\x1b[34m\n");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().what, "has no part 'blue?[34m?': it has 'red?[31m'");
}

// These files are buffers and images. They must exist, so that every other program can open the shipped files.
TEST(MeshFile, ShippedFilesNameOnlyExistingFiles) {
  const std::filesystem::path folder = HAPTON_SOURCE_DIR "/meshes";
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".gltf") continue;
    ++files;
    std::ifstream in(entry.path());
    const auto json = nlohmann::json::parse(in);
    for (const char* kind : {"buffers", "images"}) {
      for (const auto& item : json.value(kind, nlohmann::json::array())) {
        const std::string uri = item.value("uri", "?");
        if (uri.starts_with("data:")) continue;
        EXPECT_TRUE(std::filesystem::exists(folder / uri)) << entry.path() << " " << item;
      }
    }
  }
  EXPECT_GT(files, 0);
}

}  // namespace
}  // namespace hapton
