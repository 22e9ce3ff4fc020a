! A cube of vertices and triangles, meshed from Fortran; its cells are counted by the runs of its columns, without expanding them, and
! written to a file.
!
!   ./runs cube.hxc

program runs
  use hexcast
  implicit none
  real(c_double), target :: vertices(3, 8)
  integer(c_int32_t), target :: triangles(3, 12)
  character(kind=c_char), target :: name(5) = ['c', 'u', 'b', 'e', c_null_char]
  type(hexcast_facets) :: cube(1)
  type(c_ptr) :: mesher, mesh, error
  character(len=1024) :: path
  integer :: vertex

  ! vertex 0 is at the origin; x, y and z of the others are the bits of their numbers
  vertices = reshape([(real(ibits(vertex, 0, 1), c_double), real(ibits(vertex, 1, 1), c_double), &
    real(ibits(vertex, 2, 1), c_double), vertex = 0, 7)], [3, 8])
  triangles = reshape([0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, &
    2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5], [3, 12])
  cube(1)%file = c_loc(name)
  cube(1)%vertices = c_loc(vertices)
  cube(1)%n_vertices = 8
  cube(1)%triangles = c_loc(triangles)
  cube(1)%n_facets = 12

  error = c_null_ptr
  mesher = hexcast_mesher_new('{"backend": "cpu"}'//c_null_char, error)
  if (.not. c_associated(mesher)) call fail
  mesh = hexcast_mesh(mesher, &
    '{"geometries": [{"file": "cube", "flag": 7}], "cells": 10, "padding": {"cells": 2}}'//c_null_char, cube, 1_c_size_t, error)
  if (.not. c_associated(mesh)) call fail
  print '(2(i0, a))', n_cells(7), ' cells inside, ', n_cells(0), ' outside'

  call get_command_argument(1, path)
  if (hexcast_mesh_write(mesh, trim(path)//c_null_char, '{}'//c_null_char, error) /= 0) call fail
  call hexcast_mesh_free(mesh)
  call hexcast_mesher_free(mesher)

contains

  ! The number of cells that have a flag, by the runs.
  function n_cells(flag) result(n)
    integer, intent(in) :: flag
    integer(c_int64_t) :: n, column, ends(64), start
    integer(c_int32_t), pointer :: runs(:)
    integer(c_size_t) :: n_given
    type(hexcast_columns) :: columns
    type(c_ptr) :: place
    integer :: of
    if (hexcast_mesh_columns(mesh, columns, error) /= 0) call fail
    n = 0
    column = 0
    do while (column < columns%n_columns)
      if (hexcast_mesh_runs(mesh, column, size(ends, kind=c_size_t), ends, place, n_given, error) /= 0) call fail
      call c_f_pointer(place, runs, [ends(n_given)])
      start = 0
      do of = 1, int(n_given)
        n = n + n_in_column(runs(start + 1:ends(of)), flag, columns%depth)
        start = ends(of)
      end do
      column = column + n_given
    end do
  end function

  ! The number of cells of one column that have a flag.
  integer function n_in_column(runs, flag, depth)
    integer(c_int32_t), intent(in) :: runs(:), depth
    integer, intent(in) :: flag
    integer :: run, first, own
    ! from the first cell to the first run it is 0
    n_in_column = 0
    first = 0
    own = 0
    do run = 1, size(runs)
      if (own == flag) n_in_column = n_in_column + hexcast_run_first(runs(run)) - first
      first = hexcast_run_first(runs(run))
      own = hexcast_run_flag(runs(run))
    end do
    if (own == flag) n_in_column = n_in_column + depth - first
  end function

  ! Prints an error and ends the program.
  subroutine fail
    print '(a)', hexcast_text(hexcast_error_message(error))
    call hexcast_error_free(error)
    stop 1
  end subroutine
end program
