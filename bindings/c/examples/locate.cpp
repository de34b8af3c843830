// The worked example of Nederbragt and Ravani in C++.

#include <iostream>

#include <touchref.hpp>

int main() {
    try {
        const touchref::fixture fixture("cylinder-plane", "radius = 1.0\nangle_deg = 45.0", "mm");
        const touchref_probe probe = {0.0, 0.0, 0.00005};
        const touchref::solution solution = fixture.locate(
            {
                touchref::touch("cylinder", 2.9270, 2.0000, 1.6250),
                touchref::touch("cylinder", 1.7750, 2.8000, 1.4438),
                touchref::touch("cylinder", 1.3730, 2.6000, 3.1166),
                touchref::touch("cylinder", 3.5270, 3.2000, 3.1082),
                touchref::touch("plane", 2.8250, 2.4000, 4.0395),
                touchref::touch("plane", 3.9020, 5.2000, 4.0353),
                touchref::touch("plane", 2.0480, 5.2000, 4.7853),
            },
            probe);
        const touchref_frame frame = solution.frame();
        std::cout << "origin " << frame.origin[0] << " " << frame.origin[1] << " " << frame.origin[2] << "\n"
                  << solution.roots().size() << " roots\n"
                  << solution.tell("kuka") << "\n";
        for (const std::string &warning : solution.warnings()) {
            std::cout << "warning: " << warning << "\n";
        }
        return TOUCHREF_OK;
    } catch (const touchref::error &error) {
        std::cerr << error.code() << ": " << error.what() << "\n" << error.help() << "\n";
        return error.status();
    }
}
