// The refinement by ceres::TinySolver and by ceres::Solve, timed at the request of benches/peers/main.rs (which tells the
// protocol): from a start to the least-squares frame of touches on a cylinder and a plane, in standard deviations.
//
// The unknowns lead from the start R0, o0 to the frame R0 C(g), o0 + R0 v, where C(g) is the rotation of the quaternion
// (1, g) (Cayley's map): no sine, no series. It turns about the frame's own axes by 2 (dg - g x dg) / (1 + g^2).

#include <ceres/ceres.h>
#include <ceres/tiny_solver.h>
#include <ceres/version.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Rotation = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

struct Frame {
  Rotation rotation;
  Vector3d origin;
};
static_assert(sizeof(Frame) == 12 * sizeof(double), "frames are read and written as numbers");

struct Set {
  size_t problems, on_cylinder, on_plane;
  double radius, angle, sigma;
  std::vector<Frame> starts;
  std::vector<Vector3d> touches;

  size_t size() const { return on_cylinder + on_plane; }
};

Set read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  double head[6];
  file.read(reinterpret_cast<char*>(head), sizeof head);
  Set set{size_t(head[0]), size_t(head[1]), size_t(head[2]), head[3], head[4], head[5], {}, {}};
  set.starts.resize(set.problems);
  set.touches.resize(set.problems * set.size());
  file.read(reinterpret_cast<char*>(set.starts.data()), set.starts.size() * sizeof(Frame));
  file.read(reinterpret_cast<char*>(set.touches.data()), set.touches.size() * sizeof(Vector3d));
  if (!file) throw std::runtime_error("cannot read " + path);
  return set;
}

// The residuals of one problem and their derivatives by g and v.
struct Misfit {
  const Set& set;
  const Vector3d* touches;
  Frame start;

  Misfit(const Set& set, size_t index)
      : set(set), touches(&set.touches[index * set.size()]), start(set.starts[index]) {}

  static Rotation cayley(const Vector3d& g) {
    const double x = g[0], y = g[1], z = g[2], f = 2 / (1 + g.squaredNorm());
    Rotation c;
    c << 1 - f * (y * y + z * z), f * (x * y - z), f * (x * z + y),  //
        f * (x * y + z), 1 - f * (x * x + z * z), f * (y * z - x),   //
        f * (x * z - y), f * (y * z + x), 1 - f * (x * x + y * y);
    return c;
  }

  Frame frame(const double* unknowns) const {
    const Vector3d g(unknowns), v(unknowns + 3);
    return {start.rotation * cayley(g), start.origin + start.rotation * v};
  }

  // The derivative of residual i by unknown k goes to jacobian[i * row + k * column]. Size is the number of touches where
  // it is known to the compiler.
  template <int Size = Eigen::Dynamic>
  void evaluate(const double* unknowns, double* residuals, double* jacobian, size_t row, size_t column) const {
    const Vector3d g(unknowns), v(unknowns + 3);
    const Rotation turn = cayley(g);
    const Matrix3d to_fixture = (start.rotation * turn).transpose();
    const Vector3d origin = start.origin + start.rotation * v;
    const double weight = 1 / set.sigma, turning = 2 * weight / (1 + g.squaredNorm());
    const auto derive = [&](size_t i, const Vector3d& point, const Vector3d& normal) {
      const Vector3d moment = normal.cross(point);
      const Vector3d by_g = turning * (moment - moment.cross(g));
      const Vector3d by_v = -weight * (turn * normal);
      for (size_t k = 0; k < 3; k++) {
        jacobian[i * row + k * column] = by_g[k];
        jacobian[i * row + (k + 3) * column] = by_v[k];
      }
    };
    const size_t on_cylinder = Size == 7 ? 4 : set.on_cylinder, all = Size == 7 ? 7 : set.size();
    for (size_t i = 0; i < on_cylinder; i++) {
      const Vector3d point = to_fixture * (touches[i] - origin);
      const double distance = std::sqrt(point[0] * point[0] + point[1] * point[1]);
      residuals[i] = (distance - set.radius) * weight;
      if (jacobian) derive(i, point, Vector3d(point[0] / distance, point[1] / distance, 0));
    }
    const Vector3d normal(-std::sin(set.angle), 0, std::cos(set.angle));
    for (size_t i = on_cylinder; i < all; i++) {
      const Vector3d point = to_fixture * (touches[i] - origin);
      residuals[i] = normal.dot(point) * weight;
      if (jacobian) derive(i, point, normal);
    }
  }
};

template <int Size>
struct Tiny {
  using Scalar = double;
  enum { NUM_RESIDUALS = Size, NUM_PARAMETERS = 6 };
  Misfit misfit;

  int NumResiduals() const { return int(misfit.set.size()); }
  bool operator()(const double* unknowns, double* residuals, double* jacobian) const {
    misfit.evaluate<Size>(unknowns, residuals, jacobian, 1, Size == Eigen::Dynamic ? NumResiduals() : Size);
    return true;
  }
};

struct Cost : ceres::CostFunction {
  Misfit misfit;

  explicit Cost(const Misfit& misfit) : misfit(misfit) {
    set_num_residuals(int(misfit.set.size()));
    mutable_parameter_block_sizes()->push_back(6);
  }
  bool Evaluate(double const* const* unknowns, double* residuals, double** jacobians) const override {
    misfit.evaluate(unknowns[0], residuals, jacobians ? jacobians[0] : nullptr, 6, 1);
    return true;
  }
};

using Frames = std::vector<Frame>;
using Method = std::function<void(const Set&, size_t count, Frames&)>;

// The solver lives as long as the set's problems: it keeps its memory from one to the next.
template <int Size>
void by_tiny_solver(const Set& set, size_t count, double function_tolerance, Frames& frames) {
  ceres::TinySolver<Tiny<Size>> solver;
  solver.options.function_tolerance = function_tolerance;
  for (size_t i = 0; i < count; i++) {
    const Tiny<Size> function{Misfit(set, i)};
    Vector6d unknowns = Vector6d::Zero();
    solver.Solve(function, &unknowns);
    frames[i] = function.misfit.frame(unknowns.data());
  }
}

Method tiny_solver(double function_tolerance) {
  return [=](const Set& set, size_t count, Frames& frames) {
    set.size() == 7 ? by_tiny_solver<7>(set, count, function_tolerance, frames)
                    : by_tiny_solver<Eigen::Dynamic>(set, count, function_tolerance, frames);
  };
}

void by_ceres(const Set& set, size_t count, const ceres::Solver::Options& options, Frames& frames) {
  for (size_t i = 0; i < count; i++) {
    Misfit misfit(set, i);
    Cost cost(misfit);
    Vector6d unknowns = Vector6d::Zero();
    ceres::Problem::Options owner;
    owner.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(owner);
    problem.AddResidualBlock(&cost, nullptr, unknowns.data());
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    frames[i] = misfit.frame(unknowns.data());
  }
}

// Of the processor: what else the machine does is not counted.
double processor_seconds() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

double seconds(const std::function<void()>& work) {
  const double start = processor_seconds();
  work();
  return processor_seconds() - start;
}

// By whichever of the dense linear solvers is the faster for touches of this number.
Method ceres_solve(double function_tolerance, double parameter_tolerance, double gradient_tolerance) {
  ceres::Solver::Options options;
  options.function_tolerance = function_tolerance;
  options.parameter_tolerance = parameter_tolerance;
  options.gradient_tolerance = gradient_tolerance;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  constexpr size_t kTried = 20;
  auto fastest = std::make_shared<std::map<size_t, ceres::LinearSolverType>>();
  return [=](const Set& set, size_t count, Frames& frames) mutable {
    if (!fastest->count(set.size())) {
      double least = INFINITY;
      Frames some(std::min(kTried, set.problems));
      for (auto type : {ceres::DENSE_QR, ceres::DENSE_NORMAL_CHOLESKY, ceres::DENSE_QR, ceres::DENSE_NORMAL_CHOLESKY}) {
        options.linear_solver_type = type;
        const double time = seconds([&] { by_ceres(set, some.size(), options, some); });
        if (time < least) (*fastest)[set.size()] = type, least = time;
      }
    }
    options.linear_solver_type = fastest->at(set.size());
    by_ceres(set, count, options, frames);
  };
}

int main(int, char** arguments) {
  const std::string folder = arguments[1];
  const std::map<std::string, Method> methods = {
      {"tiny-solver", tiny_solver(1e-8)},
      {"tiny-solver-tight", tiny_solver(1e-16)},
      {"ceres", ceres_solve(1e-8, 1e-9, 1e-12)},
      {"ceres-tight", ceres_solve(1e-16, 1e-12, 1e-14)},
  };
  std::cout << "Ceres " << CERES_VERSION_STRING << ", Eigen " << EIGEN_WORLD_VERSION << '.' << EIGEN_MAJOR_VERSION << '.'
            << EIGEN_MINOR_VERSION << ", g++ " << __VERSION__ << std::endl;
  std::map<std::string, Set> sets;
  for (std::string line, method, name; std::getline(std::cin, line);) {
    size_t count, repeats;
    std::istringstream(line) >> method >> name >> count >> repeats;
    if (!sets.count(name)) sets.emplace(name, read(folder + "/" + name + ".f64"));
    const Set& set = sets.at(name);
    Frames frames(count);
    const double time = seconds([&] {
      for (size_t i = 0; i < repeats; i++) methods.at(method)(set, count, frames);
    });
    std::ofstream(folder + "/" + method + ".f64", std::ios::binary)
        .write(reinterpret_cast<const char*>(frames.data()), frames.size() * sizeof(Frame));
    std::cout << time * 1e9 << std::endl;
  }
}
