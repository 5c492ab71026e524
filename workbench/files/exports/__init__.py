"""Files for other programs: glTF scenes and motions, STL and 3MF solids. Every file is the same
bytes each time."""
