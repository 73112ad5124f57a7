#include "scene/mesh_file.h"

#include <assimp/config.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/BaseImporter.h>
#include <assimp/DefaultIOSystem.h>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <new>
#include <set>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "files/apart.h"
#include "files/input_file.h"
#include "scene/text_file.h"

namespace tactile_clay::scene {
namespace {

constexpr std::uint64_t max_bytes = 64 * files::mebibyte;
constexpr std::size_t max_triangles = 200000;  // some 60 MB, and a few microseconds a particle that is near
const std::set<std::string> kinds = {"stl", "dae", "obj"};

struct Triangles {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<clay::Mesh::Triangle> triangles;
};

std::string kindOf(const std::string& file) {
  std::string ending = std::filesystem::path(file).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return ending.empty() ? "" : ending.substr(1);
}

/// Leaves the reader of the one kind: the others would try their luck with the file.
void keepOnly(Assimp::Importer& importer, const std::string& kind) {
  std::vector<Assimp::BaseImporter*> others;
  for (std::size_t k = 0; k < importer.GetImporterCount(); ++k) {
    std::set<std::string> endings;
    importer.GetImporter(k)->GetExtensionList(endings);
    if (endings.count(kind) == 0) others.push_back(importer.GetImporter(k));
  }
  for (Assimp::BaseImporter* other : others) {
    importer.UnregisterLoader(other);
    delete other;
  }
}

/// Opens the mesh alone: materials and pictures that it names may be anything, such as a pipe that nobody
/// writes to.
class OnlyFile : public Assimp::DefaultIOSystem {
 public:
  explicit OnlyFile(std::string file) : file_(std::move(file)) {}

  bool Exists(const char* file) const override { return file_ == file && DefaultIOSystem::Exists(file); }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    return file_ == file ? DefaultIOSystem::Open(file, mode) : nullptr;
  }

 private:
  std::string file_;
};

/// Gathers what hangs on a node.
/// @param place of the node's parent
void gather(const aiScene& scene, const aiNode& node, const aiMatrix4x4& place, Triangles& all) {
  const aiMatrix4x4 here = place * node.mTransformation;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[m]];
    const auto first = static_cast<std::uint32_t>(all.vertices.size());
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D at = here * mesh.mVertices[v];
      all.vertices.emplace_back(at.x, at.y, at.z);
    }
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;  // points and lines
      all.triangles.emplace_back(first + face.mIndices[0], first + face.mIndices[1],
                                 first + face.mIndices[2]);
      if (all.triangles.size() > max_triangles || all.vertices.size() > 3 * max_triangles)
        throw std::runtime_error("has more than " + std::to_string(max_triangles) +
                                 " triangles, expected fewer");
    }
  }
  for (unsigned c = 0; c < node.mNumChildren; ++c) gather(scene, *node.mChildren[c], here, all);
}

Triangles read(const std::string& file, const std::string& kind) {
  Assimp::Importer importer;
  importer.SetIOHandler(new OnlyFile(file));  // which the importer deletes
  keepOnly(importer, kind);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(file, aiProcess_Triangulate | aiProcess_ValidateDataStructure);
  const std::string error = importer.GetErrorString();
  if (error == std::bad_alloc().what()) throw std::bad_alloc();
  if (scene == nullptr || scene->mRootNode == nullptr)
    throw std::runtime_error("cannot be read as " + kind + ": " + oneLine(error));
  Triangles all;
  gather(*scene, *scene->mRootNode, aiMatrix4x4(), all);
  return all;
}

template <typename T>
std::string bytesOf(const std::vector<T>& all) {
  return {reinterpret_cast<const char*>(all.data()), all.size() * sizeof(T)};
}
template <typename T>
std::vector<T> ofBytes(std::string_view bytes) {
  std::vector<T> all(bytes.size() / sizeof(T));
  std::memcpy(static_cast<void*>(all.data()), bytes.data(), all.size() * sizeof(T));
  return all;
}

/// The reader of meshes goes down nodes by recursion, follows instances without end and believes every count.
Triangles readApart(const std::string& file) {
  const std::string kind = kindOf(file);
  if (kinds.count(kind) == 0) throw std::runtime_error("is of kind '" + kind + "', expected stl, dae or obj");
  files::requireInput(file, max_bytes);
  const std::string bytes = files::runApart([&] {
    const Triangles mesh = read(file, kind);
    return bytesOf(std::vector<std::size_t>{mesh.vertices.size()}) + bytesOf(mesh.vertices) +
           bytesOf(mesh.triangles);
  });
  const std::string_view all(bytes);
  const std::size_t vertices =
      ofBytes<std::size_t>(all.substr(0, sizeof(std::size_t))).at(0) * sizeof(Eigen::Vector3d);
  return {ofBytes<Eigen::Vector3d>(all.substr(sizeof(std::size_t), vertices)),
          ofBytes<clay::Mesh::Triangle>(all.substr(sizeof(std::size_t) + vertices))};
}

}  // namespace

std::shared_ptr<const clay::Mesh> loadMesh(const std::string& file, const Eigen::Vector3d& scale) {
  const auto named = [&](const std::string& what) {
    return what.compare(0, file.size(), file) == 0 ? what : "mesh " + file + " " + what;
  };
  try {
    if (!scale.allFinite() || scale.cwiseAbs().minCoeff() == 0.0)
      throw std::runtime_error("has a scale of zero, expected other numbers");
    Triangles mesh = readApart(file);
    for (Eigen::Vector3d& v : mesh.vertices) v = v.cwiseProduct(scale);
    return std::make_shared<const clay::Mesh>(mesh.vertices, mesh.triangles);
  } catch (const std::exception& error) {
    throw std::runtime_error(named(error.what()));
  }
}

}  // namespace tactile_clay::scene
