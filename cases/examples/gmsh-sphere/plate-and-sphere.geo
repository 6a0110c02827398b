// A square plate of 100 mm and a sphere of radius 15 mm above it, quads and triangles.
SetFactory("OpenCASCADE");
radius = 15;
height = radius + 1.5 + 0.1;       // half of both thicknesses and a gap of 0.1 mm
Rectangle(1) = {-50, -50, 0, 100, 100};
Sphere(1) = {0, 0, height, radius};
Delete { Volume{1}; }
Transfinite Curve {1, 2, 3, 4} = 31;
Transfinite Surface {1};
Mesh.MeshSizeMax = 4;
Recombine Surface {1};
Physical Surface("plate") = {1};
Physical Surface("sphere") = {2};
Physical Curve("rim") = {1, 2, 3, 4};
