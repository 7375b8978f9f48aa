// Steps of classical Runge-Kutta of a tree of hinges with Pinocchio's articulated-body algorithm.
//
//     pinocchio_steps STEP COUNT EVERY REPEATS < links
//
// Each line of `links`: parent (-1: ground), axis (0, 1, 2), place of the hinge on the parent, m. All
// links are equal. Prints the processor time of a step and of one evaluation, us, then the end of
// the last link after every EVERY steps, m. The headers alone are compiled, with the flags given.
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <vector>

#include <pinocchio/fwd.hpp>
#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/kinematics.hpp>

namespace pin = pinocchio;
using Vector = Eigen::VectorXd;

static double seconds()
{
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

struct Tree {
    pin::Model model;
    pin::Data data;
    Vector tau;
};

static pin::Model read(double mass, double length, const Eigen::Vector3d &inertia)
{
    pin::Model model;
    model.gravity.linear() = Eigen::Vector3d(0.0, -8.5, -4.9);
    std::vector<pin::JointIndex> places;
    int parent, axis;
    Eigen::Vector3d at;
    while (std::cin >> parent >> axis >> at[0] >> at[1] >> at[2]) {
        pin::JointIndex before = parent < 0 ? 0 : places[parent];
        pin::SE3 place(Eigen::Matrix3d::Identity(), at);
        std::string name = "joint" + std::to_string(places.size());
        pin::JointIndex joint =
            axis == 0   ? model.addJoint(before, pin::JointModelRX(), place, name)
            : axis == 1 ? model.addJoint(before, pin::JointModelRY(), place, name)
                        : model.addJoint(before, pin::JointModelRZ(), place, name);
        Eigen::Vector3d centre(length / 2, 0, 0);
        Eigen::Matrix3d J = inertia.asDiagonal();
        model.appendBodyToJoint(joint, pin::Inertia(mass, centre, J), pin::SE3::Identity());
        places.push_back(joint);
    }
    return model;
}

// Keep of the four stages; an evaluation is one call of aba
static void step(Tree &tree, Vector &q, Vector &v, double h, Vector (&a)[4], Vector (&w)[4])
{
    w[0] = v;
    a[0] = pin::aba(tree.model, tree.data, q, w[0], tree.tau);
    w[1] = v + 0.5 * h * a[0];
    a[1] = pin::aba(tree.model, tree.data, q + 0.5 * h * w[0], w[1], tree.tau);
    w[2] = v + 0.5 * h * a[1];
    a[2] = pin::aba(tree.model, tree.data, q + 0.5 * h * w[1], w[2], tree.tau);
    w[3] = v + h * a[2];
    a[3] = pin::aba(tree.model, tree.data, q + h * w[2], w[3], tree.tau);
    q += h / 6.0 * (w[0] + 2.0 * w[1] + 2.0 * w[2] + w[3]);
    v += h / 6.0 * (a[0] + 2.0 * a[1] + 2.0 * a[2] + a[3]);
}

int main(int argc, char **argv)
{
    if (argc != 5)
        return 1;
    const double h = std::atof(argv[1]), length = 1.0, mass = 7850.0 * 0.03 * 0.04 * length;
    const long count = std::atol(argv[2]), every = std::atol(argv[3]), repeats = std::atol(argv[4]);
    const double xx = 0.03 * 0.03 + 0.04 * 0.04, yy = length * length + 0.03 * 0.03;
    const double zz = length * length + 0.04 * 0.04;
    pin::Model model = read(mass, length, mass / 12.0 * Eigen::Vector3d(xx, yy, zz));
    Tree tree{model, pin::Data(model), Vector::Zero(model.nv)};
    std::vector<Eigen::Vector3d> ends;
    double best = 1e300, single = 1e300;
    Vector q(model.nq), v(model.nv), a[4], w[4];
    for (long k = 0; k < repeats; k++) {
        q.setZero();
        v.setZero();
        ends.clear();
        double spent = 0.0;
        for (long i = 0; i < count; i += every) {
            double begin = seconds();
            for (long j = 0; j < every; j++)
                step(tree, q, v, h, a, w);
            spent += seconds() - begin;
            pin::forwardKinematics(tree.model, tree.data, q);
            ends.push_back(tree.data.oMi.back().act(Eigen::Vector3d(length, 0, 0)));
        }
        best = std::min(best, spent / count);
        double begin = seconds();
        for (long i = 0; i < count; i++)
            a[0] = pin::aba(tree.model, tree.data, q, v, tree.tau);
        single = std::min(single, (seconds() - begin) / count);
    }
    std::cout.precision(17);
    std::cout << 1e6 * best << ' ' << 1e6 * single << '\n';
    for (const auto &end : ends)
        std::cout << end[0] << ' ' << end[1] << ' ' << end[2] << '\n';
    return 0;
}
