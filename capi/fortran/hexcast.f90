! hexcast.f90: the functions of hexcast.h, which documents them, for Fortran.
!
! Made of hexcast.h by capi/tests/header: do not edit. Unsigned numbers have a sign here: flags above 127 are negative in 8 bits.

module hexcast
  use, intrinsic :: iso_c_binding
  implicit none

  integer, parameter :: hexcast_version_major = 0
  integer, parameter :: hexcast_version_minor = 1
  integer, parameter :: hexcast_version_patch = 0
  character(len=*), parameter :: hexcast_version_string = '0.1.0'

  type, bind(c) :: hexcast_array
    character(kind=c_char) :: kind(4)
    integer(c_int32_t) :: n_axes = 0
    integer(c_int64_t) :: shape(4)
    integer(c_int64_t) :: n_bytes = 0
  end type

  type, bind(c) :: hexcast_facets
    type(c_ptr) :: file = c_null_ptr
    type(c_ptr) :: corners = c_null_ptr
    integer(c_size_t) :: n_facets = 0
    type(c_ptr) :: vertices = c_null_ptr
    integer(c_size_t) :: n_vertices = 0
    type(c_ptr) :: triangles = c_null_ptr
    type(c_ptr) :: triangles64 = c_null_ptr
  end type

  type, bind(c) :: hexcast_columns
    integer(c_int32_t) :: axis = 0
    integer(c_int32_t) :: across(2)
    integer(c_int32_t) :: counts(2)
    integer(c_int32_t) :: depth = 0
    integer(c_int64_t) :: n_columns = 0
    integer(c_int64_t) :: n_runs = 0
  end type

  type, bind(c) :: hexcast_changed_run
    integer(c_int64_t) :: column = 0
    integer(c_int32_t) :: start = 0
    integer(c_int32_t) :: end = 0
    integer(c_int8_t) :: before = 0
    integer(c_int8_t) :: after = 0
  end type

  abstract interface
    function hexcast_progress(rays_done, n_rays, user) &
      bind(c)
      import :: c_ptr, c_int32_t, c_int64_t
      integer(c_int64_t), value :: rays_done
      integer(c_int64_t), value :: n_rays
      type(c_ptr), value :: user
      integer(c_int32_t) :: hexcast_progress
    end function
  end interface

  interface
    function hexcast_version() &
      bind(c, name='hexcast_version')
      import :: c_ptr
      type(c_ptr) :: hexcast_version
    end function

    function hexcast_error_code(error) &
      bind(c, name='hexcast_error_code')
      import :: c_ptr
      type(c_ptr), value :: error
      type(c_ptr) :: hexcast_error_code
    end function

    function hexcast_error_message(error) &
      bind(c, name='hexcast_error_message')
      import :: c_ptr
      type(c_ptr), value :: error
      type(c_ptr) :: hexcast_error_message
    end function

    function hexcast_error_hint(error) &
      bind(c, name='hexcast_error_hint')
      import :: c_ptr
      type(c_ptr), value :: error
      type(c_ptr) :: hexcast_error_hint
    end function

    subroutine hexcast_error_free(error) &
      bind(c, name='hexcast_error_free')
      import :: c_ptr
      type(c_ptr), value :: error
    end subroutine

    function hexcast_mesh_write(mesh, path, options, error) &
      bind(c, name='hexcast_mesh_write')
      import :: c_ptr, c_char, c_int32_t
      type(c_ptr), value :: mesh
      character(kind=c_char), intent(in) :: path(*)
      character(kind=c_char), intent(in) :: options(*)
      type(c_ptr), intent(inout) :: error
      integer(c_int32_t) :: hexcast_mesh_write
    end function

    function hexcast_mesh_dims(mesh, dims, error) &
      bind(c, name='hexcast_mesh_dims')
      import :: c_ptr, c_int32_t
      type(c_ptr), value :: mesh
      integer(c_int32_t), intent(out) :: dims(*)
      type(c_ptr), intent(inout) :: error
      integer(c_int32_t) :: hexcast_mesh_dims
    end function

    function hexcast_mesh_window(mesh, first, end, of, error) &
      bind(c, name='hexcast_mesh_window')
      import :: c_ptr, c_int32_t
      type(c_ptr), value :: mesh
      integer(c_int32_t), intent(out) :: first(*)
      integer(c_int32_t), intent(out) :: end(*)
      integer(c_int32_t), intent(out) :: of(*)
      type(c_ptr), intent(inout) :: error
      integer(c_int32_t) :: hexcast_mesh_window
    end function

    function hexcast_mesh_lines(mesh, axis, lines, n, error) &
      bind(c, name='hexcast_mesh_lines')
      import :: c_ptr, c_double, c_size_t, c_int32_t
      type(c_ptr), value :: mesh
      integer(c_int32_t), value :: axis
      real(c_double), intent(out) :: lines(*)
      integer(c_size_t), value :: n
      type(c_ptr), intent(inout) :: error
      integer(c_int32_t) :: hexcast_mesh_lines
    end function

    function hexcast_mesh_fill_box(mesh, first, end, flags, n_bytes, error) &
      bind(c, name='hexcast_mesh_fill_box')
      import :: c_ptr, c_size_t, c_int8_t, c_int32_t
      type(c_ptr), value :: mesh
      integer(c_int32_t), intent(in) :: first(*)
      integer(c_int32_t), intent(in) :: end(*)
      integer(c_int8_t), intent(out) :: flags(*)
      integer(c_size_t), value :: n_bytes
      type(c_ptr), intent(inout) :: error
      integer(c_int32_t) :: hexcast_mesh_fill_box
    end function

    function hexcast_mesh_array(mesh, of, name, array, error) &
      bind(c, name='hexcast_mesh_array')
      import :: c_ptr, c_char, c_int32_t, hexcast_array
      type(c_ptr), value :: mesh
      character(kind=c_char), intent(in) :: of(*)
      character(kind=c_char), intent(in) :: name(*)
      type(hexcast_array), intent(out) :: array
      type(c_ptr), intent(inout) :: error
      integer(c_int32_t) :: hexcast_mesh_array
    end function

    function hexcast_mesh_fill_array(mesh, of, name, bytes, n_bytes, error) &
      bind(c, name='hexcast_mesh_fill_array')
      import :: c_ptr, c_char, c_size_t, c_int32_t
      type(c_ptr), value :: mesh
      character(kind=c_char), intent(in) :: of(*)
      character(kind=c_char), intent(in) :: name(*)
      type(c_ptr), value :: bytes
      integer(c_size_t), value :: n_bytes
      type(c_ptr), intent(inout) :: error
      integer(c_int32_t) :: hexcast_mesh_fill_array
    end function

    function hexcast_mesh_doubt(mesh) &
      bind(c, name='hexcast_mesh_doubt')
      import :: c_ptr
      type(c_ptr), value :: mesh
      type(c_ptr) :: hexcast_mesh_doubt
    end function

    function hexcast_mesh_lacks(mesh) &
      bind(c, name='hexcast_mesh_lacks')
      import :: c_ptr
      type(c_ptr), value :: mesh
      type(c_ptr) :: hexcast_mesh_lacks
    end function

    function hexcast_mesh_report(mesh) &
      bind(c, name='hexcast_mesh_report')
      import :: c_ptr
      type(c_ptr), value :: mesh
      type(c_ptr) :: hexcast_mesh_report
    end function

    subroutine hexcast_mesh_free(mesh) &
      bind(c, name='hexcast_mesh_free')
      import :: c_ptr
      type(c_ptr), value :: mesh
    end subroutine

    function hexcast_mesher_new(options, error) &
      bind(c, name='hexcast_mesher_new')
      import :: c_ptr, c_char
      character(kind=c_char), intent(in) :: options(*)
      type(c_ptr), intent(inout) :: error
      type(c_ptr) :: hexcast_mesher_new
    end function

    subroutine hexcast_mesher_free(mesher) &
      bind(c, name='hexcast_mesher_free')
      import :: c_ptr
      type(c_ptr), value :: mesher
    end subroutine

    function hexcast_mesh(mesher, job, facets, n_facets, error) &
      bind(c, name='hexcast_mesh')
      import :: c_ptr, c_char, c_size_t, hexcast_facets
      type(c_ptr), value :: mesher
      character(kind=c_char), intent(in) :: job(*)
      type(hexcast_facets), intent(in) :: facets(*)
      integer(c_size_t), value :: n_facets
      type(c_ptr), intent(inout) :: error
      type(c_ptr) :: hexcast_mesh
    end function

    function hexcast_mesh_with_progress(mesher, job, facets, n_facets, progress, user, error) &
      bind(c, name='hexcast_mesh_with_progress')
      import :: c_ptr, c_funptr, c_char, c_size_t, hexcast_facets
      type(c_ptr), value :: mesher
      character(kind=c_char), intent(in) :: job(*)
      type(hexcast_facets), intent(in) :: facets(*)
      integer(c_size_t), value :: n_facets
      type(c_funptr), value :: progress
      type(c_ptr), value :: user
      type(c_ptr), intent(inout) :: error
      type(c_ptr) :: hexcast_mesh_with_progress
    end function

    function hexcast_mesh_columns(mesh, columns, error) &
      bind(c, name='hexcast_mesh_columns')
      import :: c_ptr, c_int32_t, hexcast_columns
      type(c_ptr), value :: mesh
      type(hexcast_columns), intent(out) :: columns
      type(c_ptr), intent(inout) :: error
      integer(c_int32_t) :: hexcast_mesh_columns
    end function

    function hexcast_mesh_runs(mesh, column, n_columns, ends, runs, n_given, error) &
      bind(c, name='hexcast_mesh_runs')
      import :: c_ptr, c_size_t, c_int32_t, c_int64_t
      type(c_ptr), value :: mesh
      integer(c_int64_t), value :: column
      integer(c_size_t), value :: n_columns
      integer(c_int64_t), intent(out) :: ends(*)
      type(c_ptr), intent(out) :: runs
      integer(c_size_t), intent(out) :: n_given
      type(c_ptr), intent(inout) :: error
      integer(c_int32_t) :: hexcast_mesh_runs
    end function

    function hexcast_scene_new(mesher, job, facets, n_facets, progress, user, error) &
      bind(c, name='hexcast_scene_new')
      import :: c_ptr, c_funptr, c_char, c_size_t, hexcast_facets
      type(c_ptr), value :: mesher
      character(kind=c_char), intent(in) :: job(*)
      type(hexcast_facets), intent(in) :: facets(*)
      integer(c_size_t), value :: n_facets
      type(c_funptr), value :: progress
      type(c_ptr), value :: user
      type(c_ptr), intent(inout) :: error
      type(c_ptr) :: hexcast_scene_new
    end function

    function hexcast_scene_update(scene, mesher, job, facets, n_facets, progress, user, error) &
      bind(c, name='hexcast_scene_update')
      import :: c_ptr, c_funptr, c_char, c_size_t, c_int32_t, hexcast_facets
      type(c_ptr), value :: scene
      type(c_ptr), value :: mesher
      character(kind=c_char), intent(in) :: job(*)
      type(hexcast_facets), intent(in) :: facets(*)
      integer(c_size_t), value :: n_facets
      type(c_funptr), value :: progress
      type(c_ptr), value :: user
      type(c_ptr), intent(inout) :: error
      integer(c_int32_t) :: hexcast_scene_update
    end function

    function hexcast_scene_told(scene) &
      bind(c, name='hexcast_scene_told')
      import :: c_ptr
      type(c_ptr), value :: scene
      type(c_ptr) :: hexcast_scene_told
    end function

    function hexcast_scene_changed(scene, runs, n_runs, error) &
      bind(c, name='hexcast_scene_changed')
      import :: c_ptr, c_size_t, c_int32_t
      type(c_ptr), value :: scene
      type(c_ptr), intent(out) :: runs
      integer(c_size_t), intent(out) :: n_runs
      type(c_ptr), intent(inout) :: error
      integer(c_int32_t) :: hexcast_scene_changed
    end function

    function hexcast_scene_mesh(scene, error) &
      bind(c, name='hexcast_scene_mesh')
      import :: c_ptr
      type(c_ptr), value :: scene
      type(c_ptr), intent(inout) :: error
      type(c_ptr) :: hexcast_scene_mesh
    end function

    subroutine hexcast_scene_free(scene) &
      bind(c, name='hexcast_scene_free')
      import :: c_ptr
      type(c_ptr), value :: scene
    end subroutine

    function hexcast_strlen(text) bind(c, name='strlen')
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
      integer(c_size_t) :: hexcast_strlen
    end function
  end interface

contains

  ! The characters of a text of the library, which ends with a zero byte; none for NULL.
  function hexcast_text(text) result(letters)
    type(c_ptr), intent(in) :: text
    character(len=:), allocatable :: letters
    character(kind=c_char), pointer :: bytes(:)
    integer :: i
    letters = ''
    if (.not. c_associated(text)) return
    call c_f_pointer(text, bytes, [hexcast_strlen(text)])
    allocate (character(len=size(bytes)) :: letters)
    do i = 1, size(bytes)
      letters(i:i) = bytes(i)
    end do
  end function

  ! The first cell of a run, counted from 0.
  elemental integer(c_int32_t) function hexcast_run_first(run)
    integer(c_int32_t), intent(in) :: run
    hexcast_run_first = ishft(run, -8)
  end function

  ! The flag of a run, 0 to 255.
  elemental integer(c_int32_t) function hexcast_run_flag(run)
    integer(c_int32_t), intent(in) :: run
    hexcast_run_flag = iand(run, 255_c_int32_t)
  end function
end module
