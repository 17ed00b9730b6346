// Steps per second of processor time of a world with three E-pucks in Enki, each with its camera (60 pixels in one row)
// and its eight infra-red sensors, all of which Enki computes at every step. GPL: a program of its own, linked here only.
//
//     enki STEPS
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <enki/PhysicalEngine.h>
#include <enki/robots/e-puck/EPuck.h>

int main(int argc, char* argv[]) {
    const long steps = argc > 1 ? std::atol(argv[1]) : 100000;
    Enki::World world(400, 200);
    for (int i = 0; i < 3; ++i) {
        auto* robot = new Enki::EPuck(Enki::EPuck::CAPABILITY_BASIC_SENSORS | Enki::EPuck::CAPABILITY_CAMERA);
        robot->pos = Enki::Point(60 + 40 * i, 100);
        robot->leftSpeed = 5 + i;
        robot->rightSpeed = 6;
        world.addObject(robot);
    }
    // So that every camera has something to tell apart, as on our road.
    for (int i = 0; i < 3; ++i) {
        auto* box = new Enki::PhysicalObject;
        box->setCylindric(3, 5, -1);
        box->pos = Enki::Point(80 + 60 * i, 120);
        box->setColor(Enki::Color(1, 0, 0));
        world.addObject(box);
    }
    const std::clock_t begin = std::clock();
    for (long i = 0; i < steps; ++i) world.step(0.1, 1);
    const double seconds = double(std::clock() - begin) / CLOCKS_PER_SEC;
    std::printf("%.0f\n", steps / seconds);
}
