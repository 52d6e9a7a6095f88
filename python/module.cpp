// The public C++ API for Python. weft/__init__.py adds what is easier to say in Python.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>
#include "weft/io.hpp"
#include "weft/weft.hpp"

namespace py = pybind11;

namespace {

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Indices = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

std::string shape_of(const py::array& values) {
  std::string text = "shape (";
  for (py::ssize_t k = 0; k < values.ndim(); ++k)
    text += (k > 0 ? ", " : "") + std::to_string(values.shape(k));
  return text + ")";
}

/// @throws SceneError unless `values` are so many columns of at least one row
void check_shape(const py::array& values, const char* name, int columns) {
  if (values.ndim() != 2 || values.shape(1) != columns || values.shape(0) < 1)
    throw weft::SceneError({}, name, shape_of(values),
                           "shape (n, " + std::to_string(columns) + ")");
}

template <int N>
std::vector<weft::Vec<double, N>> points(const Numbers& values, const char* name) {
  check_shape(values, name, N);
  std::vector<weft::Vec<double, N>> all(static_cast<std::size_t>(values.shape(0)));
  for (std::size_t v = 0; v < all.size(); ++v)
    for (int k = 0; k < N; ++k) all[v][k] = values.at(static_cast<py::ssize_t>(v), k);
  return all;
}

weft::Index index_of(std::int64_t value, std::size_t count, const char* name) {
  if (value < 0 || value >= static_cast<std::int64_t>(count))
    throw weft::SceneError({}, name, std::to_string(value),
                           "0 to " + std::to_string(count) + ", which is excluded");
  return static_cast<weft::Index>(value);
}

weft::Mesh mesh_of(const Numbers& vertices, const Indices& faces,
                   const std::optional<Numbers>& uv) {
  weft::Mesh mesh;
  mesh.positions = points<3>(vertices, "vertices");
  check_shape(faces, "faces", 3);
  for (py::ssize_t t = 0; t < faces.shape(0); ++t) {
    weft::Tri triangle;
    for (int k = 0; k < 3; ++k)
      triangle.v[k] = index_of(faces.at(t, k), mesh.positions.size(), "faces");
    mesh.triangles.push_back(triangle);
  }
  if (uv) {
    mesh.material = points<2>(*uv, "uv");
    if (mesh.material.size() != mesh.positions.size())
      throw weft::SceneError({}, "uv", shape_of(*uv),
                             std::to_string(mesh.positions.size()) + " rows, one a vertex");
  }
  return mesh;
}

weft::Vec3<double> vector_of(const std::vector<double>& values, const char* name) {
  if (values.size() != 3)
    throw weft::SceneError({}, name, std::to_string(values.size()) + " numbers", "three");
  return {values[0], values[1], values[2]};
}

std::vector<double> list_of(const weft::Vec3<double>& v) {
  return {v[0], v[1], v[2]};
}

template <class T, class Row>
py::array_t<T> rows(const std::vector<Row>& values, int columns) {
  py::array_t<T> array(
      {static_cast<py::ssize_t>(values.size()), static_cast<py::ssize_t>(columns)});
  auto to = array.template mutable_unchecked<2>();
  for (std::size_t i = 0; i < values.size(); ++i)
    for (int k = 0; k < columns; ++k) {
      if constexpr (requires { values[i].v[k]; })
        to(static_cast<py::ssize_t>(i), k) = static_cast<T>(values[i].v[k]);
      else
        to(static_cast<py::ssize_t>(i), k) = static_cast<T>(values[i][k]);
    }
  return array;
}

/// Arrays of a mesh; panels are its parts, or else its groups.
py::dict dict_of(const weft::Mesh& mesh) {
  const bool parts = mesh.part.size() == mesh.triangles.size();
  const std::vector<weft::Index> panel = parts ? mesh.part : mesh.group;
  py::dict d;
  d["vertices"] = rows<double>(mesh.positions, 3);
  d["faces"] = rows<std::int64_t>(mesh.triangles, 3);
  d["uv"] = rows<double>(mesh.material, 2);
  d["faces_uv"] = rows<std::int64_t>(
      mesh.material_triangles.empty() ? mesh.triangles : mesh.material_triangles, 3);
  d["panels"] = py::array_t<weft::Index>(static_cast<py::ssize_t>(panel.size()), panel.data());
  d["panel_names"] = parts ? mesh.part_names : mesh.group_names;
  d["panel_labels"] = mesh.part_labels;
  return d;
}

/// Set by SIGINT while a step runs in Python's main thread.
std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");

void note_interrupt(int) {
  interrupted = true;
}

/// Catches SIGINT while it lives.
class InterruptGuard {
 public:
  explicit InterruptGuard(bool main_thread) : active_(main_thread) {
    if (!active_) return;
    interrupted = false;
    struct sigaction action {};
    action.sa_handler = note_interrupt;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, &before_);
  }
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  ~InterruptGuard() {
    if (active_) sigaction(SIGINT, &before_, nullptr);
  }

 private:
  bool active_;
  struct sigaction before_ {};
};

/// Positions on a GPU, as other libraries take them: CUDA array interface, version 3.
struct DeviceArray {
  weft::DevicePositions positions;
  std::uintptr_t stream;                         // on which they are there
  std::shared_ptr<weft::Simulation> simulation;  // which has the memory

  py::dict interface() const {
    py::dict d;
    d["shape"] = py::make_tuple(positions.size, 3);
    d["typestr"] = "<f4";
    d["data"] = py::make_tuple(reinterpret_cast<std::uintptr_t>(positions.data), true);
    d["version"] = 3;
    d["strides"] = py::none();
    d["stream"] = stream;
    return d;
  }
};

/// A simulation that one thread at a time may use, and that can be closed.
class Simulation {
 public:
  Simulation(weft::Scene scene, const std::string& device, bool main_thread) {
    if (remeshes(scene) || scene.refinement.when != weft::Refinement::When::never)
      changes_meshes_ = true;
    const InterruptGuard guard(main_thread);
    try {
      const py::gil_scoped_release release;
      weft::validate(scene);
      const std::string chosen = device == "auto" ? weft::choose_devices(scene).device : device;
      weft::DeviceSet devices = weft::parse_devices(chosen);
      devices.stop_on(&interrupted);
      simulation_ = std::make_shared<weft::Simulation>(std::move(scene), std::move(devices));
    } catch (const weft::StoppedError&) {
      interrupt();
    }
  }

  void close() {
    const Use use(*this);
    simulation_.reset();
  }

  bool advance(double seconds, std::optional<double> budget, bool main_thread) {
    const Use use(*this);
    weft::AdvanceOptions options;
    if (budget)
      options.budget = std::chrono::duration_cast<std::chrono::nanoseconds>(
          std::chrono::duration<double>(*budget));
    weft::AdvanceResult result;
    {
      const InterruptGuard guard(main_thread);
      const py::gil_scoped_release release;
      result = simulation_->advance(seconds, options);
    }
    if (result.failure == weft::Failure::stopped) interrupt();
    if (!result) throw weft::SimulationError(result.message());
    return result.complete;
  }

  py::array positions(const weft::ClothId& cloth) {
    const Use use(*this);
    const std::span<const weft::Vec3f> places = simulation_->positions(cloth);
    const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(places.size()), 3};
    const auto* numbers = places.empty() ? nullptr : places.front().e;
    // Where meshes change, the memory of a view might be gone.
    if (changes_meshes_) return py::array_t<float>(shape, numbers);
    // The view keeps what it looks at, also if this is closed.
    using Kept = std::shared_ptr<weft::Simulation>;
    const py::capsule kept(new Kept(simulation_), [](void* p) { delete static_cast<Kept*>(p); });
    py::array_t<float> view(shape, numbers, kept);
    view.attr("setflags")(false);
    return view;
  }

  /// @param stream as in the array interface: 1 is CUDA's default stream
  DeviceArray device_positions(const weft::ClothId& cloth, std::uintptr_t stream) {
    const Use use(*this);
    void* handle = stream == 1 ? nullptr : reinterpret_cast<void*>(stream);
    DeviceArray array{simulation_->device_positions(cloth, handle), stream, simulation_};
    if (array.positions.gpu < 0)
      throw weft::DeviceError("device_positions: the simulation runs on the CPU; use positions()");
    return array;
  }

  /// Calls f(weft::Simulation&) while no other thread uses the simulation.
  template <class F>
  auto with(F f) {
    const Use use(*this);
    return f(*simulation_);
  }

 private:
  /// @throws std::runtime_error if another thread is in here, or it is closed
  class Use {
   public:
    explicit Use(Simulation& of) : busy_(of.busy_) {
      if (busy_.exchange(true))
        throw std::runtime_error(
            "the simulation is in use by another thread; allowed: one at a time");
      if (of.simulation_) return;
      busy_ = false;
      throw std::runtime_error("the simulation is closed");
    }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    ~Use() { busy_ = false; }

   private:
    std::atomic<bool>& busy_;
  };

  [[noreturn]] static void interrupt() {
    PyErr_SetNone(PyExc_KeyboardInterrupt);
    throw py::error_already_set();
  }

  std::shared_ptr<weft::Simulation> simulation_;  // null: closed
  std::atomic<bool> busy_{false};
  bool changes_meshes_ = false;
};

template <class Part>
void move(Simulation& simulation, const weft::Id<Part>& id, const Numbers& places) {
  const auto to = points<3>(places, "places");
  simulation.with([&](weft::Simulation& s) { s.move(id, to); });
}

template <class Part>
void bind_id(py::module_& m, const char* name) {
  py::class_<weft::Id<Part>>(m, name)
      .def("__index__", [](const weft::Id<Part>& id) { return id.index; })
      .def("__repr__", [name](const weft::Id<Part>& id) {
        return std::string(name) + "(" + std::to_string(id.index) + ")";
      });
}

}  // namespace

PYBIND11_MODULE(_weft, m) {
  py::register_exception<weft::SceneError>(m, "SceneError", PyExc_ValueError);
  py::register_exception<weft::DeviceError>(m, "DeviceError", PyExc_RuntimeError);
  py::register_exception<weft::SimulationError>(m, "SimulationError", PyExc_RuntimeError);
  m.attr("__version__") = WEFT_VERSION;
  bind_id<weft::Cloth>(m, "ClothId");
  bind_id<weft::Obstacle>(m, "ObstacleId");
  bind_id<weft::Pin>(m, "PinId");

  py::class_<weft::Scene>(m, "Scene")
      .def(py::init<>())
      .def_property(
          "gravity", [](const weft::Scene& s) { return list_of(s.gravity); },
          [](weft::Scene& s, const std::vector<double>& g) { s.gravity = vector_of(g, "gravity"); })
      .def_property(
          "time_step", [](const weft::Scene& s) { return s.time.step; },
          [](weft::Scene& s, double step) { s.time.step = step; })
      .def_property(
          "frame_rate", [](const weft::Scene& s) { return s.time.frame_rate; },
          [](weft::Scene& s, double rate) { s.time.frame_rate = rate; })
      .def_property(
          "thickness", [](const weft::Scene& s) { return s.contact.thickness; },
          [](weft::Scene& s, std::optional<double> thickness) { s.contact.thickness = thickness; })
      .def_property(
          "friction", [](const weft::Scene& s) { return s.contact.friction; },
          [](weft::Scene& s, double friction) { s.contact.friction = friction; })
      .def_readwrite("method", &weft::Scene::method)
      .def_property_readonly("frames", [](const weft::Scene& s) { return s.time.frames; })
      .def_readonly("warnings", &weft::Scene::warnings)
      .def_property_readonly("cloths",
                             [](const weft::Scene& s) {
                               std::vector<weft::ClothId> ids;
                               for (std::size_t c = 0; c < s.cloths.size(); ++c)
                                 ids.push_back({static_cast<weft::Index>(c), s.identity.number()});
                               return ids;
                             })
      .def(
          "add_cloth",
          [](weft::Scene& s, const Numbers& vertices, const Indices& faces,
             const std::optional<Numbers>& uv, const std::string& fabric, const std::string& name) {
            weft::Cloth cloth;
            cloth.name = name;
            cloth.mesh = mesh_of(vertices, faces, uv);
            cloth.material = s.add(weft::fabric(fabric));
            return s.add(std::move(cloth));
          })
      .def("add_obstacle",
           [](weft::Scene& s, const Numbers& vertices, const Indices& faces, double friction,
              const std::string& name) {
             weft::LiveObstacle obstacle(mesh_of(vertices, faces, {}));
             obstacle.friction = friction;
             obstacle.name = name;
             return s.add(std::move(obstacle));
           })
      .def("pin", [](weft::Scene& s, const weft::ClothId& cloth, const Indices& vertices) {
        std::vector<weft::Index> chosen;
        for (py::ssize_t k = 0; k < vertices.size(); ++k)
          chosen.push_back(index_of(vertices.data()[k], 0x7fffffff, "vertices"));
        return s.pin(cloth, std::move(chosen));
      });
  m.def("load", [](const std::string& file, const std::vector<std::string>& overrides) {
    return weft::load_scene(file, overrides);
  });

  m.def("frame_numbers", [](const std::string& run) { return weft::frame_numbers(run); });
  m.def("load_frame", [](const std::string& run, int number) {
    py::list all;
    for (const weft::FrameMesh& frame : weft::load_frame(run, number)) {
      py::dict entry = dict_of(frame.mesh);
      entry["name"] = frame.name;
      entry["obstacle"] = frame.obstacle;
      all.append(entry);
    }
    return all;
  });

  py::class_<DeviceArray>(m, "DeviceArray")
      .def_property_readonly("__cuda_array_interface__", &DeviceArray::interface)
      .def_property_readonly("gpu", [](const DeviceArray& a) { return a.positions.gpu; });
  py::class_<Simulation>(m, "Simulation")
      .def(py::init<weft::Scene, const std::string&, bool>())
      .def("close", &Simulation::close)
      .def("advance", &Simulation::advance)
      .def("positions", &Simulation::positions)
      .def("device_positions", &Simulation::device_positions)
      .def("move", &move<weft::Obstacle>)
      .def("move", &move<weft::Pin>)
      .def("release",
           [](Simulation& s, const weft::PinId& id) {
             s.with([&](weft::Simulation& w) { w.release(id); });
           })
      .def("set_gravity",
           [](Simulation& s, const std::vector<double>& g) {
             s.with([&](weft::Simulation& w) { w.set_gravity(vector_of(g, "gravity")); });
           })
      .def("set_wind",
           [](Simulation& s, const std::vector<double>& velocity, double density, double drag) {
             s.with([&](weft::Simulation& w) {
               w.set_wind({density, vector_of(velocity, "velocity"), drag});
             });
           })
      .def("set_forces",
           [](Simulation& s, const weft::ClothId& cloth, const std::optional<Numbers>& forces) {
             std::vector<weft::Vec3<double>> all;
             if (forces) all = points<3>(*forces, "forces");
             s.with([&](weft::Simulation& w) { w.set_forces(cloth, all); });
           })
      .def("state",
           [](Simulation& s) {
             return py::bytes(s.with([](weft::Simulation& w) { return w.state(); }));
           })
      .def("restore",
           [](Simulation& s, const std::string& state) {
             s.with([&](weft::Simulation& w) { w.restore(state); });
           })
      .def("energy",
           [](Simulation& s) {
             const weft::Energy e = s.with([](weft::Simulation& w) { return w.energy(); });
             py::dict energy;
             energy["kinetic"] = e.kinetic;
             energy["elastic"] = e.elastic;
             energy["gravitational"] = e.gravitational;
             return energy;
           })
      .def_property_readonly(
          "time",
          [](Simulation& s) { return s.with([](weft::Simulation& w) { return w.time(); }); })
      .def_property_readonly("state_hash", [](Simulation& s) {
        return s.with([](weft::Simulation& w) { return w.state_hash(); });
      });
}
